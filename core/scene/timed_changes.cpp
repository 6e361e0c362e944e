// [[change]]: changes of laws, neurons, masses, rest lengths and the integrator at a time.
#include <set>

#include <fmt/format.h>

#include "plugin_host/law_use.hpp"
#include "scene/component.hpp"
#include "scene/element_sets.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"

namespace springnet::scene {
namespace {

using Components = std::vector<std::shared_ptr<const Component>>;

// The springs and elements that a change of laws is for, and their materials.
struct Chosen {
  std::vector<SpringIndex> springs;
  std::vector<ElementIndex> elements;
  std::set<MaterialIndex> materials;
};

Components laws_of(const Chosen& chosen, ComponentKind kind, const Network& network, const PluginHost& plugins) {
  Components laws;
  for (const MaterialIndex index : chosen.materials) {
    const Material& material = network.materials()[index];
    const std::optional<LawUse>& use = kind == ComponentKind::spring_function ? material.spring : material.viscosity;
    if (!use) continue;
    const std::shared_ptr<const Component> law = component_of(*use, kind, plugins);
    if (std::find(laws.begin(), laws.end(), law) == laws.end()) laws.push_back(law);
  }
  return laws;
}

Components neurons_of(const std::vector<NodeIndex>& nodes, const Network& network, const PluginHost& plugins) {
  std::set<std::uint32_t> kinds;
  for (const NodeIndex node : nodes) kinds.insert(network.nodes()[node].neuron);
  Components neurons;
  for (const std::uint32_t kind : kinds)
    neurons.push_back(plugins.require(ComponentKind::neuron, network.neurons()[kind].id));
  return neurons;
}

bool has_any(const Table& table, std::initializer_list<const char*> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](const char* key) { return table.has(key); });
}

Chosen choose(const Table& table, const Scene& scene) {
  Chosen chosen;
  const Network& network = scene.network;
  if (const auto elements = table.find("elements")) chosen.elements = select_elements(*elements, scene.elements);
  if (const auto select = table.find("select"); select && chosen.elements.empty())
    chosen.springs = select_springs(*select, network);
  for (const SpringIndex spring : chosen.springs) chosen.materials.insert(network.springs().materials()[spring]);
  for (const ElementIndex element : chosen.elements) chosen.materials.insert(network.elements()[element].material);
  return chosen;
}

void read_laws(const Table& table, const Chosen& chosen, const Network& network, const PluginHost& plugins,
               Change& change) {
  const auto read = [&](const char* key, ComponentKind kind, Named what, ParameterValues& values) {
    if (const auto given = table.find(key))
      values =
          read_values(given->open_table(fmt::format("change.{}", key)), what, laws_of(chosen, kind, network, plugins));
  };
  read("spring", ComponentKind::spring_function, Named::parameters, change.spring);
  read("viscosity", ComponentKind::viscosity_function, Named::parameters, change.viscosity);
  read("inputs", ComponentKind::spring_function, Named::inputs, change.spring_inputs);
  read("viscosity_inputs", ComponentKind::viscosity_function, Named::inputs, change.viscosity_inputs);
  const bool springs = chosen.elements.empty();
  for (const char* key : {"rest_length", "rest_length_scale"})
    if (const auto given = table.find(key); given && !springs)
      given->fail("is for springs; elements have a 'reference' or a 'reference_scale'");
  for (const char* key : {"reference", "reference_scale"})
    if (const auto given = table.find(key); given && springs)
      given->fail("is for elements; springs have a 'rest_length' or a 'rest_length_scale'");
  if (const auto value = table.find("rest_length")) change.reference = value->number_from_0("m");
  if (const auto value = table.find("reference")) change.reference = value->number();
  for (const char* key : {"rest_length_scale", "reference_scale"}) {
    const auto value = table.find(key);
    if (!value) continue;
    if (change.reference) value->fail("cannot be combined with a value itself; remove one of them");
    change.reference_scale = value->number_above_0("");
  }
}

void read_change(const Table& table, const PluginHost& plugins, const Files& files, std::size_t& selected,
                 Scene& scene) {
  Network& network = scene.network;
  Change change;
  change.time = table.need("time").number_from_0("s");
  const bool of_nodes = has_any(table, {"neuron", "mass"});
  const bool of_laws = has_any(table, {"spring", "viscosity", "inputs", "viscosity_inputs", "rest_length",
                                       "rest_length_scale", "reference", "reference_scale"});
  const auto remove = table.find("remove");
  const auto integrator = table.find("integrator");
  if (!of_nodes && !of_laws && !remove && !integrator)
    table.fail(
        "changes nothing; add what changes: 'spring', 'viscosity', 'inputs', 'rest_length', 'mass', 'neuron', "
        "'remove', 'integrator', …");
  if (of_nodes || (of_laws && !table.has("elements"))) static_cast<void>(table.need("select"));
  if (of_laws) {
    const Chosen chosen = choose(table, scene);
    change.springs = chosen.springs;
    change.elements = chosen.elements;
    read_laws(table, chosen, network, plugins, change);
  }
  if (of_nodes) {
    change.nodes = select_nodes(table.need("select"), network);
    if (const auto mass = table.find("mass")) change.mass = mass->number_above_0("kg");
    if (const auto neuron = table.find("neuron"))
      change.neuron = read_values(neuron->open_table("change.neuron"), Named::parameters,
                                  neurons_of(change.nodes, network, plugins));
  }
  if (integrator)
    change.integrator = integrator->is_text() ? read_component_name(*integrator, ComponentKind::integrator, plugins)
                                              : read_component(integrator->open_table("change.integrator"), "name",
                                                               ComponentKind::integrator, plugins, files);
  Change removal;
  removal.time = change.time;
  if (remove) {
    removal.remove = true;
    switch (remove->choice({"springs", "elements", "nodes"})) {
      case 0:
        removal.springs = select_springs(table.need("select"), network);
        break;
      case 1:
        removal.elements = select_elements(table.need("elements"), scene.elements);
        break;
      default:
        removal.nodes = select_nodes(table.need("select"), network);
    }
  }
  for (const Change* const each : {&change, &removal})
    count_selected(table.value(), each->springs.size() + each->elements.size() + each->nodes.size(), selected);
  table.value().at_this_place([&] {
    if (of_laws || of_nodes || integrator) network.add_change(change);
    if (remove) network.add_change(removal);
  });
}

}  // namespace

void read_timed_changes(const Table& root, const PluginHost& plugins, const Files& files, Scene& scene) {
  std::size_t selected = 0;
  for (const Value& value : root.tables("change")) read_change(value.table("change"), plugins, files, selected, scene);
}

}  // namespace springnet::scene
