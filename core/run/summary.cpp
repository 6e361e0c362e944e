#include <algorithm>

#include <nlohmann/json.hpp>
#include <springnet/run.hpp>
#include <springnet/version.hpp>

namespace springnet {

namespace {

using Json = nlohmann::ordered_json;

double ratio(double numerator, double denominator) { return denominator > 0.0 ? numerator / denominator : 0.0; }

Json json_of_integrator(const RunSummary& summary) {
  Json options = Json::object();
  for (const auto& [name, value] : summary.integrator.parameters) {
    const auto choice = summary.choices.find(name);
    options[name] = choice == summary.choices.end() ? Json(value) : Json(choice->second);
  }
  return {{"name", summary.integrator.id}, {"options", options}};
}

Json json_of_pace(const RunSummary& summary) {
  if (!summary.pace) return nullptr;
  const PaceReport& pace = *summary.pace;
  return {{"factor", pace.factor},
          {"frames_per_s", ratio(pace.factor, summary.time_step)},
          {"frames", pace.frames},
          {"missed_frames", pace.missed},
          {"greatest_delay_s", pace.greatest_delay}};
}

}  // namespace

std::vector<PluginUse> plugins_used(const Scene& scene, const PluginHost& plugins) {
  std::vector<PluginUse> uses;
  const auto add = [&](ComponentKind kind, const std::string& id) {
    const auto component = plugins.require(kind, id);
    const springnet_plugin& plugin = *component->plugin;
    if (std::any_of(uses.begin(), uses.end(), [&](const PluginUse& use) { return use.id == plugin.id; })) return;
    uses.push_back({plugin.id, plugin.version, component->file.filename().string()});
  };
  add(ComponentKind::integrator, scene.options.integrator.id);
  std::vector<bool> in_use(scene.network.neurons().size(), false);
  for (const Node& node : scene.network.nodes()) in_use[node.neuron] = true;
  for (std::size_t k = 0; k < in_use.size(); ++k)
    if (in_use[k]) add(ComponentKind::neuron, scene.network.neurons()[k].id);
  for (const Material& material : scene.network.materials()) {
    // Formulas are of no plugin.
    const auto is_of_plugin = [](const std::optional<LawUse>& use) { return use && use->component == nullptr; };
    if (is_of_plugin(material.spring)) add(ComponentKind::spring_function, material.spring->id);
    if (is_of_plugin(material.viscosity)) add(ComponentKind::viscosity_function, material.viscosity->id);
  }
  std::sort(uses.begin(), uses.end(), [](const PluginUse& a, const PluginUse& b) { return a.id < b.id; });
  return uses;
}

// Numbers that are not finite become null.
std::string to_json(const RunSummary& summary) {
  Json plugins = Json::array();
  for (const PluginUse& use : summary.plugins) {
    plugins.push_back({{"id", use.id}, {"version", use.version}, {"file", use.file}});
  }
  Json volumes = Json::array();
  for (const VolumeSummary& volume : summary.volumes) {
    volumes.push_back({{"element", volume.element},
                       {"name", volume.name},
                       {"first_m3", volume.first},
                       {"last_m3", volume.last},
                       {"smallest_m3", volume.smallest},
                       {"greatest_m3", volume.greatest},
                       {"leaked", volume.leaked}});
  }
  Json cut_short = Json::array();
  for (const CutShort& each : summary.cut_short) cut_short.push_back({{"file", each.file}, {"until_s", each.until}});
  const Json document{
      {"scene", summary.scene},
      {"title", summary.title},
      {"outcome", summary.outcome},
      {"error", summary.error.empty() ? Json(nullptr) : Json(summary.error)},
      {"nodes", summary.nodes},
      {"springs", summary.springs},
      {"springs_left", summary.springs_left},
      {"elements", summary.elements},
      {"elements_left", summary.elements_left},
      {"integrator", json_of_integrator(summary)},
      {"time_step_s", summary.time_step},
      {"duration_s", summary.duration},
      {"simulated_s", summary.simulated},
      {"steps", summary.steps},
      {"sweeps", summary.sweeps},
      {"sweeps_per_step", ratio(static_cast<double>(summary.sweeps), static_cast<double>(summary.steps))},
      {"unsettled_steps", summary.unsettled},
      {"divided_steps", summary.divided},
      {"substeps", summary.substeps},
      {"stages", summary.stages},
      {"largest_residual_n", summary.largest_residual},
      {"last_residual_n", summary.last_residual},
      {"cut", summary.events.cut},
      {"ruptured", summary.events.ruptured},
      {"elements_removed", summary.events.elements_removed},
      {"touched", summary.events.touched},
      {"released", summary.events.released},
      {"slipped", summary.events.slipped},
      {"stuck", summary.events.stuck},
      {"jammed", summary.events.jammed},
      {"met", summary.events.met},
      {"parted", summary.events.parted},
      {"enclosed_volumes", volumes},
      {"wall_s", summary.wall},
      {"output_wall_s", summary.output_wall},
      {"times_real_time", ratio(summary.simulated, summary.wall)},
      {"pace", json_of_pace(summary)},
      {"spring_updates_per_s", ratio(summary.spring_updates, summary.wall)},
      {"statistics", summary.statistics},
      {"notes", summary.notes},
      {"threads", summary.threads},
      {"instruction_set", summary.instruction_set},
      {"version", version()},
      {"plugins", plugins},
      {"records", summary.records},
      {"output_bytes", summary.bytes},
      {"files", summary.files},
      {"cut_short", cut_short},
  };
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace springnet
