#include <algorithm>

#include <nlohmann/json.hpp>
#include <springnet/inspection.hpp>

namespace springnet {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const std::optional<Range>& range) {
  if (!range) return nullptr;
  return {{"smallest", range->smallest}, {"largest", range->largest}};
}

Json json_of(const Vector3& vector) { return Json::array({vector.x(), vector.y(), vector.z()}); }

template <class Value>
Json json_of(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

const char* name_of(TimeConstantLimit::Kind kind) {
  switch (kind) {
    case TimeConstantLimit::Kind::known:
      return "known";
    case TimeConstantLimit::Kind::estimate:
      return "estimate";
    case TimeConstantLimit::Kind::none:
      return "none";
    default:
      return "unknown";
  }
}

Json json_of(const TimeConstantLimit& limit, const std::optional<double>& time_step) {
  const bool known = limit.time_constant > 0.0;
  Json result{{"limit", name_of(limit.kind)},
              {"time_constant_s", known ? Json(limit.time_constant) : Json(nullptr)},
              {"time_step_over_limit", known && time_step ? Json(*time_step / limit.time_constant) : Json(nullptr)},
              {"set_by", nullptr}};
  if (limit.set_by) {
    const Bottleneck& set_by = *limit.set_by;
    result["set_by"] = {{"node", set_by.node},
                        {"mass_kg", set_by.mass},
                        {"spring", json_of(set_by.spring)},
                        {"element", json_of(set_by.element)}};
    if (set_by.spring || set_by.element) {
      result["set_by"]["stiffness_n_per_m"] = set_by.stiffness;
      result["set_by"]["damping_ns_per_m"] = set_by.damping;
      result["set_by"]["elastic_share"] = set_by.elastic_share;
      result["set_by"]["viscous_share"] = set_by.viscous_share;
    }
  }
  return result;
}

Json limits(const Inspection& inspection) {
  Json result = Json::object();
  for (const TimeConstantLimit& limit : inspection.limits) {
    // Two integrators may name a rule alike: the first one's has the name alone.
    const std::string& name = limit.name();
    result[result.contains(name) ? limit.integrator + "." + name : name] = json_of(limit, inspection.options.time_step);
  }
  return result;
}

Json largest(const std::vector<Part>& parts) {
  Json result = Json::array();
  for (std::size_t i = 0; i < std::min(parts.size(), parts_listed_at_most); ++i) {
    const Part& part = parts[i];
    result.push_back({{"first_node", part.first_node},
                      {"nodes", part.nodes},
                      {"springs", part.springs},
                      {"fixed_nodes", part.fixed_nodes}});
  }
  return result;
}

Json json_of(const Mobility& mobility) {
  const auto known = [&](std::size_t count) { return mobility.known ? Json(count) : Json(nullptr); };
  return {{"mechanisms", known(mobility.mechanisms)},
          {"rigid_body_motions", mobility.rigid_body_motions},
          {"redundant_rigids", known(mobility.redundant_rigids)},
          {"springs_under_tension", mobility.springs_under_tension},
          {"springs_under_compression", mobility.springs_under_compression}};
}

Json json_of(const std::optional<Vibration>& slowest, const std::optional<double>& time_step) {
  if (!slowest) return nullptr;
  return {{"period_s", slowest->period},
          {"damping_ratio", slowest->damping_ratio},
          {"time_steps_a_period", time_step ? Json(slowest->period / *time_step) : Json(nullptr)}};
}

Json json_of(const std::vector<Hint>& hints) {
  Json result = Json::array();
  for (const Hint& hint : hints) result.push_back({{"kind", name_of(hint.kind)}, {"text", hint.text}});
  return result;
}

Json json_of(const UnusualSprings& springs) {
  Json worst = Json::array();
  for (const UnusualSpring& spring : springs.worst) {
    worst.push_back(
        {{"spring", spring.spring}, {"nodes", Json::array({spring.first, spring.second})}, {"value", spring.value}});
  }
  return {{"count", springs.count},
          {"median", springs.median > 0.0 ? Json(springs.median) : Json(nullptr)},
          {"bound", springs.bound > 0.0 ? Json(springs.bound) : Json(nullptr)},
          {"worst", worst}};
}

Json json_of(const Suspicions& suspicions) {
  return {{"stiffness_n_per_m", json_of(suspicions.stiffness)},
          {"damping_ns_per_m", json_of(suspicions.damping)},
          {"stiffness_over_mass_per_s2", json_of(suspicions.elastic_rate)},
          {"damping_over_mass_per_s", json_of(suspicions.viscous_rate)},
          {"strain", json_of(suspicions.strain)},
          {"springs_without_direction", suspicions.springs_without_direction},
          {"springs_that_soften", suspicions.springs_that_soften},
          {"nodes_without_springs", suspicions.nodes_without_springs},
          {"lightest_node", json_of(suspicions.lightest)},
          {"heaviest_node", json_of(suspicions.heaviest)}};
}

}  // namespace

std::string to_json(const Inspection& inspection) {
  const Json document{
      {"nodes", inspection.nodes},
      {"springs", inspection.springs},
      {"bodies", inspection.bodies},
      {"fixed_nodes", inspection.fixed_nodes},
      {"moved_nodes", inspection.moved_nodes},
      {"rigids", inspection.rigids},
      {"planes", inspection.planes},
      {"instruments", inspection.instruments},
      {"loads", inspection.loads},
      {"cuts", inspection.cuts},
      {"neurons", inspection.neurons},
      {"elements", inspection.elements},
      {"spring_functions", inspection.spring_functions},
      {"viscosity_functions", inspection.viscosity_functions},
      {"element_spring_functions", inspection.element_spring_functions},
      {"element_viscosity_functions", inspection.element_viscosity_functions},
      {"total_mass_kg", inspection.total_mass},
      {"mass_kg", json_of(inspection.mass)},
      {"length_m", json_of(inspection.length)},
      {"rest_length_m", json_of(inspection.rest_length)},
      {"stiffness_n_per_m", json_of(inspection.stiffness)},
      {"damping_ns_per_m", json_of(inspection.damping)},
      {"springs_under_load", inspection.springs_under_load},
      {"lower_m", json_of(inspection.lower)},
      {"upper_m", json_of(inspection.upper)},
      {"part_count", inspection.parts.size()},
      {"parts", largest(inspection.parts)},
      {"nodes_without_springs", inspection.nodes_without_springs},
      {"memory_bytes", inspection.memory_bytes},
      {"time_step_s", json_of(inspection.options.time_step)},
      {"theta", inspection.options.theta()},
      {"time_constants", limits(inspection)},
      {"unknown_because", inspection.unknown_because.empty() ? Json(nullptr) : Json(inspection.unknown_because)},
      {"unique_time_constant_s", json_of(inspection.unique_time_constant)},
      {"mobility", json_of(inspection.mobility)},
      {"slowest_vibration", json_of(inspection.slowest, inspection.options.time_step)},
      {"hints", json_of(inspection.hints)},
      {"suspicions", json_of(inspection.suspicions)},
  };
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace springnet
