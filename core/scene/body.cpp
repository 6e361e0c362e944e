#include <set>

#include <fmt/format.h>

#include "scene/component.hpp"
#include "scene/parts.hpp"

namespace springnet::scene {
namespace {

const char* const needs_a_law =
    "has springs, but neither 'spring' nor 'viscosity' says what they are made of; add spring = { type = …, … }";

Node read_prototype(const Table& body, const PluginHost& plugins, Network& network) {
  Node node;
  const Table neuron = body.need("neuron").open_table("body.neuron");
  const LawUse use = read_component(neuron, "type", ComponentKind::neuron, plugins);
  node.mass = neuron.need("mass").number_above_0("kg");
  node.neuron = network.add_neuron(use);
  if (const auto velocity = body.find("velocity")) node.velocity = velocity->vector();
  return node;
}

Lattice read_lattice(const Table& mesh) {
  Lattice lattice;
  const std::vector<Value> nodes = mesh.need("lattice").elements(3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    constexpr std::int64_t largest = std::numeric_limits<std::uint32_t>::max();
    lattice.nodes[axis] = static_cast<std::uint32_t>(nodes[axis].integer(1, largest));
  }
  const Value spacing = mesh.need("spacing");
  if (spacing.is_list()) {
    const std::vector<Value> spacings = spacing.elements(3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lattice.spacing[static_cast<Eigen::Index>(axis)] = spacings[axis].number_above_0("m");
    }
  } else {
    lattice.spacing.setConstant(spacing.number_above_0("m"));
  }
  if (const auto origin = mesh.find("origin")) lattice.origin = origin->vector();
  if (const auto diagonals = mesh.find("diagonals")) {
    lattice.diagonals = static_cast<Diagonals>(diagonals->choice({"none", "face", "space", "all"}));
  }
  return lattice;
}

void add_lattice_body(const Table& body, const std::string& name, const Node& prototype,
                      std::optional<MaterialIndex> material, Network& network) {
  const Table mesh = body.need("mesh").table("body.mesh");
  const Lattice lattice = read_lattice(mesh);
  const bool one_node = lattice.nodes == std::array<std::uint32_t, 3>{1, 1, 1};
  if (!material && !one_node) body.fail(needs_a_law);
  mesh.value().at_this_place([&] {
    if (material) {
      network.add_lattice(name, lattice, prototype, *material);
      return;
    }
    Node node = prototype;
    node.position = lattice.origin;
    network.begin_body(name);
    network.add_node(node);
    network.end_body();
  });
}

void add_explicit_spring(const Value& pair, std::size_t node_count, MaterialIndex material, NodeIndex first_node,
                         Network& network) {
  const std::vector<Value> ends = pair.elements(2);
  std::array<NodeIndex, 2> nodes{};
  for (std::size_t end = 0; end < 2; ++end) {
    const std::int64_t node = ends[end].integer(0);
    if (node >= static_cast<std::int64_t>(node_count)) {
      ends[end].fail(fmt::format("there is no node {}, the body has {}, numbered from 0", node, node_count));
    }
    nodes[end] = first_node + static_cast<NodeIndex>(node);
  }
  if (nodes[0] == nodes[1]) pair.fail("joins a node to itself; give two different nodes");
  if (network.nodes()[nodes[0]].position == network.nodes()[nodes[1]].position) {
    pair.fail("has length zero, both nodes are at the same place; move one, or leave the spring out");
  }
  pair.at_this_place([&] { network.add_spring(nodes[0], nodes[1], material); });
}

void add_explicit_body(const Table& body, const std::string& name, Node node, std::optional<MaterialIndex> material,
                       Network& network) {
  const Value nodes = body.need("nodes");
  const std::vector<Value> positions = nodes.elements();
  if (positions.empty()) nodes.fail("lists no node; give one position [x, y, z] or more");
  const std::optional<Value> springs = body.find("springs");
  const std::vector<Value> pairs = springs ? springs->elements() : std::vector<Value>();
  if (!pairs.empty() && !material) body.fail(needs_a_law);

  network.begin_body(name);
  const auto first_node = static_cast<NodeIndex>(network.nodes().size());
  for (const Value& position : positions) {
    node.position = position.vector();
    position.at_this_place([&] { network.add_node(node); });
  }
  for (const Value& pair : pairs) add_explicit_spring(pair, positions.size(), *material, first_node, network);
  network.end_body();
}

void read_body(const Table& body, const PluginHost& plugins, std::set<std::string>& names, Network& network) {
  const Value name = body.need("name");
  if (!names.insert(name.text()).second) name.fail("another body has this name; names are unique");
  const bool has_mesh = body.has("mesh"), has_nodes = body.has("nodes");
  if (has_mesh && has_nodes) body.fail("has both 'mesh' and 'nodes'; leave one out");
  if (!has_mesh && !has_nodes) body.fail("has no nodes; add mesh = { lattice = [4, 4, 4], spacing = 1.0 } or 'nodes'");
  if (has_mesh && body.has("springs")) body.find("springs")->fail("a mesh has springs of its own; remove this key");

  const Node prototype = read_prototype(body, plugins, network);
  const Material material = read_material(body, plugins);
  std::optional<MaterialIndex> index;
  if (material.spring || material.viscosity) index = network.add_material(material);
  const auto scale = body.find("rest_length_scale");
  const double factor = scale ? scale->number_above_0("") : 1.0;

  if (has_mesh) {
    add_lattice_body(body, name.text(), prototype, index, network);
  } else {
    add_explicit_body(body, name.text(), prototype, index, network);
  }
  if (!scale) return;
  const Body& added = network.bodies().back();
  for (SpringIndex i = added.first_spring; i < added.first_spring + added.spring_count; ++i) {
    scale->at_this_place([&] { network.set_rest_length(i, factor * network.springs()[i].rest_length); });
  }
}

}  // namespace

void read_bodies(const Table& root, const PluginHost& plugins, Network& network) {
  std::set<std::string> names;
  for (const Value& body : root.tables("body")) read_body(body.table("body"), plugins, names, network);
  if (network.nodes().empty()) root.fail("the scene has no body; add a [[body]]");
}

}  // namespace springnet::scene
