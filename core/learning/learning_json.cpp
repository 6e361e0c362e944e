#include <cmath>
#include <string>

#include <nlohmann/json.hpp>
#include <springnet/learn.hpp>
#include <springnet/version.hpp>

namespace springnet {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json course(const LearnCourse& of) {
  Json points = Json::array();
  for (const LearnCourse::Point& each : of.points) {
    Json values = Json::array();
    for (const double value : each.values) values.push_back(value);
    points.push_back({{"work_in_motions", each.work},
                      {"cost", number(each.cost)},
                      {"rms", number(each.rms)},
                      {"values", std::move(values)}});
  }
  return {{"method", of.method}, {"parameters", of.parameters}, {"points", std::move(points)}};
}

}  // namespace

std::string to_json(const LearnedNet& learned) {
  Json courses = Json::array();
  for (const LearnCourse& each : learned.courses) courses.push_back(course(each));
  Json parameters = Json::array();
  for (const LearnedParameter& each : learned.parameters) {
    Json entry{{"kind", name_of(each.kind)}};
    if (!each.parameter.empty()) entry["parameter"] = each.parameter;
    entry[std::string(member_name(each.kind, each.of_elements))] = each.member;
    if (!each.body.empty()) entry["body"] = each.body;
    if (each.together) entry["together"] = true;
    if (each.axis >= 0) entry["axis"] = each.axis;
    entry["variable"] = each.variable;
    if (each.variables > 1) entry["variables"] = each.variables;
    entry["start"] = each.start;
    entry["value"] = each.value;
    entry["lower"] = number(each.lower);
    entry["upper"] = number(each.upper);
    entry["determined"] = number(each.determined);
    entry["has_influence"] = each.has_influence;
    entry["from_guess"] = number(each.from_guess);
    entry["at_bound"] = each.at_bound;
    entry["outside_interval"] = each.is_outside;
    entry["by_half_time_step"] = number(each.by_time_step);
    if (!learned.starts.empty()) {
      entry["starts_lower"] = number(each.starts_lower);
      entry["starts_upper"] = number(each.starts_upper);
    }
    parameters.push_back(std::move(entry));
  }
  Json history = Json::array();
  for (const LearnProgress& each : learned.history)
    history.push_back({{"iteration", each.iteration},
                       {"share_of_time", each.share},
                       {"guess_weight", each.guess_weight},
                       {"cost", each.cost},
                       {"rms", each.rms}});
  Json starts = Json::array();
  for (const LearnedStart& each : learned.starts)
    starts.push_back({{"start_cost", number(each.start_cost)},
                      {"cost", number(each.cost)},
                      {"iterations", each.iterations},
                      {"as_good", each.is_as_good},
                      {"reason", each.reason}});
  Json curve = Json::array();
  for (const GuessPoint& each : learned.guess_curve)
    curve.push_back({{"weight", each.weight}, {"rms", number(each.rms)}, {"distance", number(each.distance)}});
  Json json{
      {"springnet", version()},
      {"method", learned.method},
      {"observed_values", learned.observed},
      {"variables", learned.variables},
      {"start_cost", number(learned.start_cost)},
      {"cost", number(learned.cost)},
      {"smooth_cost", number(learned.smooth_cost)},
      {"rms", number(learned.rms)},
      {"fit",
       {{"share_of_motion", number(learned.fit.share_of_motion)},
        {"correlation_in_time", number(learned.fit.correlation_in_time)},
        {"warning", learned.fit.warning.empty() ? Json(nullptr) : Json(learned.fit.warning)}}},
      {"reason", learned.reason},
      {"error", learned.failure.empty() ? Json(nullptr) : Json(learned.failure)},
      {"guess_weight", learned.guess_weight},
      {"guess_curve", curve},
      {"undetermined_directions", learned.undetermined},
      {"singular_values", learned.singular_values},
      {"parameters", parameters},
      {"starts", starts},
      {"history", history},
      {"notes", learned.notes},
  };
  if (learned.held_out.observed > 0)
    json["held_out"] = {{"observed_values", learned.held_out.observed},
                        {"start_rms", number(learned.held_out.start_rms)},
                        {"rms", number(learned.held_out.rms)},
                        {"half_time_step_rms", number(learned.held_out.half_step_rms)}};
  if (!learned.courses.empty()) json["courses"] = std::move(courses);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace springnet
