#include <algorithm>

#include <fmt/format.h>

#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "scene/element_sets.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"

namespace springnet::scene {
namespace {

void read_quantities(const Value& value, OutputOptions& output) {
  output.position = output.velocity = output.force = false;
  for (const Value& quantity : value.elements()) {
    bool* const wanted[] = {&output.position, &output.velocity, &output.force};
    *wanted[quantity.choice({"position", "velocity", "force"})] = true;
  }
  if (!output.position && !output.velocity && !output.force) {
    value.fail(
        "names no quantity; write 'position', 'velocity', 'force', or leave out the file: output.trajectory = false");
  }
}

void read_recorded_elements(const Value& value, const std::vector<ElementSet>& sets, OutputOptions& output) {
  if (value.is_boolean()) {
    output.elements = value.boolean();
    output.element_numbers.clear();
    return;
  }
  if (!value.is_list()) value.wrong_type("true, false or a list of names of [[element]]");
  output.elements = true;
  output.element_numbers = select_elements(value, sets);
  if (output.element_numbers.empty()) value.fail("names no element; leave out the file: output.elements = false");
}

// Elements of which bodies consist are recorded on request: a solid has more of them than nodes.
void leave_out_bodies(Scene& scene) {
  bool any = false;
  std::vector<ElementIndex> others;
  for (const ElementSet& set : scene.elements) {
    any = any || set.of == ElementSet::Of::body;
    for (ElementIndex k = 0; set.of == ElementSet::Of::table && k < set.count; ++k) others.push_back(set.first + k);
  }
  if (!any) return;
  scene.output.elements = !others.empty();
  scene.output.element_numbers = std::move(others);
}

// Whether a spring or element that is recorded has a law with internal states.
bool records_states(const Network& network, const OutputOptions& output) {
  std::vector<bool> has_states;
  for (const Material& material : network.materials()) {
    has_states.push_back(std::any_of(output.law_states.begin(), output.law_states.end(), [&](const LawStates& law) {
      const std::optional<LawUse>& use =
          law.kind == ComponentKind::spring_function ? material.spring : material.viscosity;
      return use && use->id == law.law;
    }));
  }
  const auto any = [&](const auto& all, const auto& chosen) {
    if (chosen.empty())
      return std::any_of(all.begin(), all.end(), [&](const auto& each) { return has_states[each.material]; });
    return std::any_of(chosen.begin(), chosen.end(), [&](std::uint32_t k) { return has_states[all[k].material]; });
  };
  return any(network.springs(), output.springs) || (output.elements && any(network.elements(), output.element_numbers));
}

}  // namespace

void read_output(const Table& root, const PluginHost& plugins, Scene& scene) {
  const Network& network = scene.network;
  OutputOptions& output = scene.output;
  output.law_states = find_law_states(network, plugins);
  leave_out_bodies(scene);
  const auto value = root.find("output");
  if (!value) return;
  const Table table = value->table("output");
  if (const auto interval = table.find("interval")) output.interval = interval->number_from_0("s");
  const auto read_flag = [&](const char* key, bool& flag) {
    if (const auto wanted = table.find(key)) flag = wanted->boolean();
  };
  read_flag("trajectory", output.trajectory);
  read_flag("reactions", output.reactions);
  read_flag("surfaces", output.surfaces);
  read_flag("rigid", output.rigid);
  read_flag("contacts", output.contacts);
  read_flag("energies", output.energies);
  read_flag("states", output.states);
  read_flag("vtk", output.vtk);
  read_flag("view", output.view);
  if (const auto elements = table.find("elements")) read_recorded_elements(*elements, scene.elements, output);
  if (const auto size = table.find("view_size")) output.view_size = size->number_above_0("bytes");
  if (const auto nodes = table.find("nodes")) output.nodes = select_nodes(*nodes, network);
  if (const auto springs = table.find("springs")) output.springs = select_springs(*springs, network);
  if (const auto quantities = table.find("quantities")) read_quantities(*quantities, output);
  if (const auto format = table.find("format")) {
    output.format = static_cast<OutputOptions::Format>(format->choice({"csv", "binary"}));
  }
  if (const auto precision = table.find("precision")) {
    output.precision = static_cast<OutputOptions::Precision>(precision->choice({"double", "single"}));
  }
  if (const auto interval = table.find("vtk_interval")) output.vtk_interval = interval->number_from_0("s");
  if (output.states && !records_states(network, output)) {
    table.find("states")->fail(
        "no spring or element that is recorded (output.springs, output.elements) has a law with internal states; leave "
        "it out, or record others");
  }
}

}  // namespace springnet::scene

namespace springnet {

std::vector<LawStates> find_law_states(const Network& network, const PluginHost& plugins) {
  std::vector<LawStates> found;
  const auto add = [&](ComponentKind kind, const std::optional<LawUse>& use) {
    if (!use) return;
    const auto known = [&](const LawStates& each) { return each.kind == kind && each.law == use->id; };
    if (std::any_of(found.begin(), found.end(), known)) return;
    const auto component = use->component != nullptr ? use->component : plugins.find(kind, use->id);
    if (!component || component->law().state_count == 0) return;
    LawStates law{kind, use->id, {}};
    for (std::uint32_t j = 0; j < component->law().state_count; ++j) {
      const springnet_parameter& state = *component->law().states[j];
      law.states.push_back({state.name, state.unit, kind == ComponentKind::viscosity_function});
    }
    found.push_back(std::move(law));
  };
  for (const Material& material : network.materials()) {
    add(ComponentKind::spring_function, material.spring);
    add(ComponentKind::viscosity_function, material.viscosity);
  }
  return found;
}

}  // namespace springnet
