#include <nlohmann/json.hpp>
#include <springnet/validation.hpp>
#include <springnet/version.hpp>

namespace springnet {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const EventCounts& events) {
  return {{"cut", events.cut},           {"ruptured", events.ruptured}, {"touched", events.touched},
          {"released", events.released}, {"slipped", events.slipped},   {"stuck", events.stuck},
          {"jammed", events.jammed},     {"met", events.met},           {"parted", events.parted}};
}

Json json_of(const Validation& validation, const ValidationRun& run) {
  return {
      {"integrator", run.integrator.id},
      {"time_step_s", run.time_step},
      {"of_scene", run.of_scene},
      {"max_error_m", run.error.max},
      {"max_error_share", validation.share_of_displacement(run.error.max)},
      {"rms_error_m", run.error.rms},
      {"max_error_node", run.error.node},
      {"max_error_time_s", run.error.time},
      {"order", run.order},
      {"steps", run.steps},
      {"sweeps_per_step", run.steps > 0 ? static_cast<double>(run.sweeps) / static_cast<double>(run.steps) : 0.0},
      {"wall_s", run.wall},
      {"outcome", run.outcome},
      {"error", run.finished() ? Json(nullptr) : Json(run.failure)},
      {"reached_s", run.reached},
      {"events", json_of(run.events)},
      {"max_error_by_time_m", run.error.max_by_time},
  };
}

}  // namespace

// Numbers that are not finite become null.
std::string to_json(const Validation& validation) {
  Json runs = Json::array();
  for (const ValidationRun& run : validation.runs) runs.push_back(json_of(validation, run));
  const Json reference{
      {"integrator", validation.reference},
      {"relative_tolerance", validation.relative_tolerance},
      {"certifying_tolerance", validation.certifying_tolerance},
      {"uncertainty_m", validation.uncertainty()},
      {"uncertainty_by_time_m", validation.certification.max_by_time},
      {"wall_s", validation.reference_wall},
      {"events", json_of(validation.reference_events)},
  };
  Json second_order = nullptr;
  if (validation.second_order) {
    second_order = json_of(validation, *validation.second_order);
    second_order["theta"] = 0.5;
    second_order["better"] = validation.second_order_is_better();
  }
  const Displacement& moved = validation.displacement;
  const Json displacement{
      {"max_m", moved.max}, {"node", moved.node}, {"time_s", moved.time}, {"deformation_m", moved.deformation}};
  const Json document{
      {"scene", validation.scene},
      {"title", validation.title},
      {"nodes", validation.nodes},
      {"springs", validation.springs},
      {"duration_s", validation.duration},
      {"reference", reference},
      {"displacement", displacement},
      {"runs", runs},
      {"second_order", second_order},
      {"observed_order", validation.observed_order},
      {"notes", validation.notes},
      {"times_s", validation.times},
      {"version", version()},
  };
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace springnet
