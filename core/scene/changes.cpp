#include <map>

#include <fmt/format.h>

#include "scene/component.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"
#include "scene/time_table.hpp"
#include "scene/value_tables.hpp"
#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

void require_one_of(const Table& table, const std::vector<std::string>& keys) {
  std::string list;
  for (const std::string& key : keys) {
    if (table.has(key)) return;
    list += (list.empty() ? "'" : ", '") + key + "'";
  }
  table.fail("changes nothing; add one or more of " + list);
}

void read_node_change(const Table& table, const PluginHost& plugins, const Files& files, Network& network) {
  require_one_of(table, {"mass", "velocity", "neuron"});
  const std::vector<NodeIndex> nodes = select_nodes(table.need("select"), network);
  std::optional<double> mass;
  std::optional<Vector3> velocity;
  std::optional<std::uint32_t> neuron;
  if (const auto value = table.find("mass")) mass = value->number_above_0("kg");
  if (const auto value = table.find("velocity")) velocity = value->vector();
  if (const auto value = table.find("neuron")) {
    neuron = network.add_neuron(
        read_component(value->open_table("node.neuron"), "type", ComponentKind::neuron, plugins, files));
  }
  for (const NodeIndex index : nodes) {
    Node node = network.nodes()[index];
    node.mass = mass.value_or(node.mass);
    node.velocity = velocity.value_or(node.velocity);
    node.neuron = neuron.value_or(node.neuron);
    table.value().at_this_place([&] { network.set_node(index, node); });
  }
}

// What a [[spring]] changes of one of the two functions: nothing, removes it, or replaces it.
struct FunctionChange {
  bool given = false;
  std::optional<LawUse> function;
};

FunctionChange read_function_change(const Table& table, std::string_view key, ComponentKind kind,
                                    const PluginHost& plugins, const Files& files) {
  const std::optional<Value> value = table.find(key);
  if (!value) return {};
  if (value->is_text()) {
    if (value->text() != "none") value->fail("must be a table { type = …, … }, or \"none\" to remove the function");
    return {true, std::nullopt};
  }
  return {true, read_law(*value, fmt::format("spring.{}", key), kind, plugins, files)};
}

void change_materials(const Table& table, const std::vector<SpringIndex>& springs, const PluginHost& plugins,
                      const Files& files, Network& network) {
  const FunctionChange spring = read_function_change(table, "spring", ComponentKind::spring_function, plugins, files);
  const FunctionChange viscosity =
      read_function_change(table, "viscosity", ComponentKind::viscosity_function, plugins, files);
  if (!spring.given && !viscosity.given) return;
  std::map<MaterialIndex, MaterialIndex> changed;
  for (const SpringIndex index : springs) {
    const MaterialIndex old = network.springs()[index].material;
    auto found = changed.find(old);
    if (found == changed.end()) {
      Material material = network.materials()[old];
      if (spring.given) material.spring = spring.function;
      if (viscosity.given) material.viscosity = viscosity.function;
      if (!material.spring && !material.viscosity) {
        table.fail(
            fmt::format("leaves spring {} without any function; to remove springs, use [[cut]] with time = 0", index));
      }
      found = changed.emplace(old, network.add_material(material)).first;
    }
    network.set_spring_material(index, found->second);
  }
}

void read_spring_change(const Table& table, const PluginHost& plugins, const Files& files, Network& network) {
  require_one_of(table, {"spring", "viscosity", "rest_length", "rest_length_scale", "values"});
  if (const auto values = table.find("values")) {
    refuse_beside(table, {"select", "spring", "viscosity", "rest_length", "rest_length_scale"}, "values");
    read_spring_values(*values, plugins, files, network);
    return;
  }
  const std::vector<SpringIndex> springs = select_springs(table.need("select"), network);
  change_materials(table, springs, plugins, files, network);
  const auto length = table.find("rest_length");
  const auto scale = table.find("rest_length_scale");
  if (length && scale) scale->fail("cannot be combined with 'rest_length'; remove one of them");
  const double fixed = length ? length->number_from_0("m") : 0.0;
  const double factor = scale ? scale->number_above_0("") : 1.0;
  if (!length && !scale) return;
  for (const SpringIndex index : springs) {
    (length ? *length : *scale).at_this_place([&] {
      network.set_rest_length(index, length ? fixed : factor * network.springs()[index].rest_length);
    });
  }
}

void read_fix(const Table& table, Network& network) {
  for (const NodeIndex node : select_nodes(table.need("select"), network)) network.fix(node);
}

void read_cut(const Table& table, std::size_t& selected, Network& network) {
  Cut cut;
  cut.time = table.need("time").number_from_0("s");
  if (!table.has("select") && !table.has("polygon")) {
    table.fail("cuts nothing; add 'select' (springs), 'polygon' (three corners or more) or both");
  }
  if (const auto selection = table.find("select")) {
    cut.springs = select_springs(*selection, network);
    count_selected(*selection, cut.springs.size(), selected);
  }
  if (const auto polygon = table.find("polygon")) {
    for (const Value& corner : polygon->elements()) cut.polygon.push_back(corner.vector());
    constexpr std::size_t max_corners = 10'000;  // every spring is tested against each
    if (cut.polygon.size() > max_corners) {
      polygon->fail(fmt::format("has {} corners, at most {} are allowed; leave out those that change its shape least",
                                grouped(cut.polygon.size()), grouped(max_corners)));
    }
    if (cut.polygon.empty()) polygon->fail("has no corners; give three or more [x, y, z]");
  }
  (table.has("polygon") ? *table.find("polygon") : table.value()).at_this_place([&] { network.add_cut(cut); });
}

}  // namespace

void read_changes(const Table& root, const PluginHost& plugins, const Files& files, const std::vector<Shape>& shapes,
                  Scene& scene) {
  Network& network = scene.network;
  for (const Value& value : root.tables("node")) read_node_change(value.table("node"), plugins, files, network);
  for (const Value& value : root.tables("spring")) read_spring_change(value.table("spring"), plugins, files, network);
  for (const Value& value : root.tables("fix")) read_fix(value.table("fix"), network);
  read_loads(root, shapes, scene);
  std::size_t selected = 0;
  for (const Value& value : root.tables("cut")) read_cut(value.table("cut"), selected, network);
}

}  // namespace springnet::scene
