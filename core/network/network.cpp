#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "network/checks.hpp"

namespace springnet {
namespace {

using namespace checks;

constexpr double length_accuracy = 1e-8;  // relative; the integrators keep lengths to this

// A string that identifies a use: equal for equal uses only.
std::string key_of(const LawUse& use, std::string_view what) {
  if (use.id.empty()) fail(fmt::format("a {} has no id: name a component of a plugin", what));
  // Laws given as formulas have one id, and components of their own, which the network keeps.
  std::string key = fmt::format("{}:{};{};", use.id.size(), use.id, static_cast<const void*>(use.component.get()));
  for (const auto& [name, value] : use.parameters) {
    if (!std::isfinite(value)) {
      fail(fmt::format("{} '{}': parameter '{}' must be a finite number, is {}", what, use.id, name, value));
    }
    const double positive_zero = value == 0.0 ? 0.0 : value;
    key += fmt::format("{}:{}={:x};", name.size(), name, std::bit_cast<std::uint64_t>(positive_zero));
  }
  for (const auto& [name, values] : use.tables) {
    key += fmt::format("{}:{}[{}]", name.size(), name, values.size());
    const std::size_t begin = key.size();
    key.resize(begin + values.size() * sizeof(double));
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (!std::isfinite(values[k])) {
        fail(fmt::format("{} '{}': table '{}': row {} must be a finite number, is {}", what, use.id, name, k + 1,
                         values[k]));
      }
      const double positive_zero = values[k] == 0.0 ? 0.0 : values[k];
      std::memcpy(key.data() + begin + k * sizeof(double), &positive_zero, sizeof(double));
    }
  }
  return key;
}

// Numbers in the tables of all materials, which are kept for each: 0.8 GB with the keys. What laws prepare from them
// comes to that while a simulation exists: 2 GB for "table".
constexpr std::size_t most_in_tables = 50'000'000;

std::size_t count_table_values(const std::optional<LawUse>& use) {
  std::size_t count = 0;
  if (use)
    for (const auto& [name, values] : use->tables) count += values.size();
  return count;
}

void check_rest_length(double length) {
  if (!(std::isfinite(length) && length >= 0)) {
    fail(fmt::format("a rest length must be a finite number of at least 0 m, is {}", length));
  }
}

}  // namespace

Network::Network() { add_neuron({"point_mass", {}}); }

std::uint32_t Network::add_neuron(const LawUse& neuron) {
  const auto [found, is_new] =
      neuron_index_.emplace(key_of(neuron, "neuron"), static_cast<std::uint32_t>(neurons_.size()));
  if (is_new) neurons_.push_back(neuron);
  return found->second;
}

MaterialIndex Network::add_material(const Material& material) {
  if (!material.spring && !material.viscosity) {
    fail("a material needs a spring function, a viscosity function or both");
  }
  const std::string spring = material.spring ? key_of(*material.spring, "spring function") : "";
  const std::string viscosity = material.viscosity ? key_of(*material.viscosity, "viscosity function") : "";
  const auto [found, is_new] = material_index_.emplace(fmt::format("{}\n{}{}", spring.size(), spring, viscosity),
                                                       static_cast<MaterialIndex>(materials_.size()));
  if (!is_new) return found->second;
  const std::size_t more = count_table_values(material.spring) + count_table_values(material.viscosity);
  if (table_values_ + more > most_in_tables) {
    material_index_.erase(found);
    fail(fmt::format("the tables of all materials have more than {} values: leave out some points", most_in_tables));
  }
  table_values_ += more;
  materials_.push_back(material);
  return found->second;
}

void Network::check_node(const Node& node, NodeIndex index) const {
  const auto what = [&] { return fmt::format("node {}", index); };
  if (!node.position.allFinite())
    fail(fmt::format("{}: its position must be finite, is {}", what(), text(node.position)));
  if (!node.velocity.allFinite())
    fail(fmt::format("{}: its velocity must be finite, is {}", what(), text(node.velocity)));
  if (!(std::isfinite(node.mass) && node.mass > 0)) {
    fail(fmt::format("{}: its mass must be a finite number above 0 kg, is {}", what(), node.mass));
  }
  if (node.neuron >= neurons_.size()) {
    fail(fmt::format("{}: there is no neuron {}, only {}: add it with add_neuron", what(), node.neuron,
                     neurons_.size()));
  }
}

NodeIndex Network::add_node(const Node& node) {
  if (nodes_.size() >= max_count) fail(fmt::format("a network has at most {} nodes", max_count));
  const auto index = static_cast<NodeIndex>(nodes_.size());
  check_node(node, index);
  Node added = node;
  if (node.fixed) added.velocity.setZero();
  nodes_.push_back(added);
  return index;
}

// Growing by at least one half, so that thousands of small bodies do not cause a copy each.
void Network::reserve_nodes(std::size_t count) {
  const std::size_t capacity = nodes_.positions().capacity();
  if (count > capacity) nodes_.reserve(std::max(count, capacity + capacity / 2));
}
void Network::reserve_springs(std::size_t count) {
  const std::size_t capacity = springs_.ends().capacity();
  if (count > capacity) springs_.reserve(std::max(count, capacity + capacity / 2));
}

void Network::set_node(NodeIndex index, const Node& node) {
  if (index >= nodes_.size()) fail(fmt::format("there is no node {}, only {}", index, nodes_.size()));
  check_node(node, index);
  if (node.position != nodes_[index].position) check_lengths(index, node.position);
  Node changed = node;
  if (moving_nodes_.contains(index)) changed.fixed = true;
  if (changed.fixed) changed.velocity.setZero();
  nodes_.set(index, changed);
}

void Network::move_nodes(const std::vector<Vector3>& positions) {
  if (positions.size() != nodes_.size())
    fail(fmt::format("{} positions for {} nodes: one each is needed", positions.size(), nodes_.size()));
  for (NodeIndex k = 0; k < positions.size(); ++k)
    if (!positions[k].allFinite()) fail(fmt::format("node {}: its position must be finite", k));
  constexpr double kept = 1e-6;
  for (const auto& [first, second, length] : rigids_) {
    const double apart = distance(positions[first], positions[second]);
    if (!(std::abs(length - apart) <= kept * length))
      fail(fmt::format("nodes {} and {} are joined rigidly, at {:.10g} m, and would be {:.10g} m apart", first, second,
                       length, apart));
  }
  nodes_.positions_ = positions;
}

void Network::fix(NodeIndex node) {
  if (node >= nodes_.size()) fail(fmt::format("there is no node {} to fix, only {}", node, nodes_.size()));
  nodes_.fixed_.set(node, 1);
  nodes_.velocity_.set(node, Vector3::Zero());
}

void Network::check_material(MaterialIndex material) const {
  if (material >= materials_.size()) {
    fail(fmt::format("there is no material {}, only {}: add it with add_material", material, materials_.size()));
  }
}

void Network::check_spring(SpringIndex spring) const {
  if (spring >= springs_.size()) fail(fmt::format("there is no spring {}, only {}", spring, springs_.size()));
}

void Network::check_ends(NodeIndex first, NodeIndex second, std::string_view what) const {
  for (const NodeIndex end : {first, second}) {
    if (end >= nodes_.size()) {
      fail(fmt::format("a {} from node {} to node {}: there is no node {}, only {}", what, first, second, end,
                       nodes_.size()));
    }
  }
  if (first == second) fail(fmt::format("a {} joins node {} to itself: give two different nodes", what, first));
}

SpringIndex Network::add_spring(NodeIndex first, NodeIndex second, MaterialIndex material,
                                std::optional<double> rest_length) {
  if (springs_.size() >= max_count) fail(fmt::format("a network has at most {} springs", max_count));
  check_ends(first, second, "spring");
  check_material(material);
  const double length = rest_length ? *rest_length : distance(nodes_[first].position, nodes_[second].position);
  if (!rest_length && length == 0) {
    fail(fmt::format(
        "the spring from node {} to node {} has length zero: both are at {}; move one, or give the spring a "
        "rest length",
        first, second, text(nodes_[first].position)));
  }
  check_rest_length(length);
  springs_.push_back({first, second, material, length});
  return static_cast<SpringIndex>(springs_.size() - 1);
}

void Network::check_lengths(NodeIndex node, const Vector3& position) const {
  for (const auto& [first, second, length] : rigids_) {
    if (first != node && second != node) continue;
    const NodeIndex other = first == node ? second : first;
    const double apart = distance(position, nodes_[other].position);
    if (std::abs(length - apart) <= length_accuracy * length) continue;
    fail(fmt::format(
        "node {} cannot be placed at {}: it is joined rigidly to node {}, at {:.10g} m, and would be {:.10g} m away; "
        "place nodes before they are joined",
        node, text(position), other, length, apart));
  }
}

RigidIndex Network::add_rigid(NodeIndex first, NodeIndex second, std::optional<double> length) {
  if (rigids_.size() >= max_count) fail(fmt::format("a network has at most {} rigid connections", max_count));
  check_ends(first, second, "rigid connection");
  const auto what = [&] { return fmt::format("the rigid connection from node {} to node {}", first, second); };
  const double apart = distance(nodes_[first].position, nodes_[second].position);
  if (!std::isfinite(apart)) fail(fmt::format("{}: their distance is too great to be a number", what()));
  if (!(apart > 0)) {
    fail(fmt::format("{} has length zero: both are at {}; move one, or use one node in place of two", what(),
                     text(nodes_[first].position)));
  }
  if (length && !(std::isfinite(*length) && *length > 0)) {
    fail(fmt::format("{}: its length must be a finite number above 0 m, is {}", what(), *length));
  }
  if (length && std::abs(*length - apart) > length_accuracy * *length) {
    fail(fmt::format(
        "{}: its length is {:.10g} m, but the nodes are {:.10g} m apart: place them at that distance, or leave the "
        "length out",
        what(), *length, apart));
  }
  const auto [lower, upper] = std::minmax(first, second);
  if (!rigid_ends_.insert(std::uint64_t{lower} << 32 | upper).second) {
    fail(fmt::format("there are two rigid connections between node {} and node {}: one is enough", first, second));
  }
  rigids_.push_back({first, second, length.value_or(apart)});
  return static_cast<RigidIndex>(rigids_.size() - 1);
}

void Network::set_spring_material(SpringIndex spring, MaterialIndex material) {
  check_spring(spring);
  check_material(material);
  springs_.material_.set(spring, material);
}

void Network::set_rest_length(SpringIndex spring, double rest_length) {
  check_spring(spring);
  check_rest_length(rest_length);
  springs_.rest_length_.set(spring, rest_length);
}

void Network::begin_body(const std::string& name) {
  if (in_body_) fail(fmt::format("body '{}' begins before body '{}' has ended", name, bodies_.back().name));
  if (name.empty()) fail("a body needs a name");
  if (!body_names_.insert(name).second) fail(fmt::format("there are two bodies '{}': rename one", name));
  bodies_.push_back({.name = name,
                     .first_node = static_cast<NodeIndex>(nodes_.size()),
                     .node_count = 0,
                     .first_spring = static_cast<SpringIndex>(springs_.size()),
                     .spring_count = 0,
                     .first_element = static_cast<ElementIndex>(elements_.size()),
                     .first_face = faces_.size()});
  in_body_ = true;
}

void Network::end_body() {
  if (!in_body_) fail("end_body without begin_body: no body has been begun");
  Body& body = bodies_.back();
  body.node_count = static_cast<NodeIndex>(nodes_.size()) - body.first_node;
  body.spring_count = static_cast<SpringIndex>(springs_.size()) - body.first_spring;
  body.element_count = static_cast<ElementIndex>(elements_.size()) - body.first_element;
  body.face_count = faces_.size() - body.first_face;
  in_body_ = false;
}

}  // namespace springnet
