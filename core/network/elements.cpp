#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "network/checks.hpp"
#include "network/corners.hpp"
#include "network/invariant_values.hpp"

namespace springnet {
namespace {

using namespace checks;

std::uint64_t directed(NodeIndex from, NodeIndex to) { return std::uint64_t{from} << 32 | to; }

// Every edge must belong to two triangles, once in each direction.
void check_closed(const std::vector<NodeIndex>& nodes) {
  std::unordered_map<std::uint64_t, std::size_t> triangle_of;  // by directed edge
  const auto corner = [&](std::size_t triangle, std::size_t k) { return nodes[3 * triangle + k % 3]; };
  for (std::size_t t = 0; t < nodes.size() / 3; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [other, is_new] = triangle_of.emplace(directed(corner(t, k), corner(t, k + 1)), t);
      if (is_new) continue;
      fail(
          fmt::format("an enclosed volume: triangles {} and {} both run from node {} to node {}: turn one of them, so "
                      "that all are counterclockwise seen from outside, or remove duplicates",
                      other->second, t, corner(t, k), corner(t, k + 1)));
    }
  }
  for (std::size_t t = 0; t < nodes.size() / 3; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (triangle_of.contains(directed(corner(t, k + 1), corner(t, k)))) continue;
      fail(
          fmt::format("an enclosed volume: the surface is open at the edge from node {} to node {} of triangle {}: "
                      "close it, or use areas or the volumes of tetrahedra",
                      corner(t, k), corner(t, k + 1), t));
    }
  }
}

// Of three or four points; d is not read for three.
double value_at(Invariant invariant, const invariants::Point& a, const invariants::Point& b, const invariants::Point& c,
                const invariants::Point& d) {
  switch (value_invariant(invariant)) {
    case Invariant::angle:
      return invariants::angle(a, b, c);
    case Invariant::dihedral:
      return invariants::dihedral(a, b, c, d);
    case Invariant::area:
      return invariants::area(a, b, c);
    default:
      return invariants::volume(a, b, c, d);
  }
}

}  // namespace

std::string_view name_of(Invariant invariant) noexcept {
  switch (invariant) {
    case Invariant::angle:
      return "angle";
    case Invariant::dihedral:
      return "dihedral";
    case Invariant::area:
      return "area";
    case Invariant::volume:
      return "volume";
    case Invariant::chain:
      return "chain";
    case Invariant::triangle:
      return "triangle";
    case Invariant::hinge:
      return "hinge";
    case Invariant::tetrahedron:
      return "tetrahedron";
    case Invariant::enclosed_volume:
      break;
  }
  return "enclosed_volume";
}

std::string_view unit_of(Invariant invariant) noexcept {
  switch (value_invariant(invariant)) {
    case Invariant::angle:
    case Invariant::dihedral:
      return "rad";
    case Invariant::area:
      return "m^2";
    default:
      return "m^3";
  }
}

ElementIndex Network::add_element(Invariant invariant, std::vector<NodeIndex> nodes, MaterialIndex material,
                                  std::optional<double> reference) {
  if (reads_several(invariant) && !reference) return add_element(invariant, std::move(nodes), material, {}, {0, 0, 0});
  if (reads_several(invariant)) {
    fail(fmt::format("an element of {} has several reference values: give the positions of its nodes at rest instead",
                     name_of(invariant)));
  }
  return add_checked(invariant, std::move(nodes), material, reference);
}

ElementIndex Network::add_element(Invariant shape, std::vector<NodeIndex> nodes, MaterialIndex material,
                                  std::vector<Vector3> rest, const Vector3& direction) {
  if (!reads_several(shape)) {
    fail(fmt::format("an element of {} has one reference value: positions at rest are for laws over several scalars",
                     name_of(shape)));
  }
  const ElementIndex element = add_checked(shape, std::move(nodes), material, std::nullopt);
  try {
    set_rest(element, std::move(rest), direction);
  } catch (...) {
    elements_.pop_back();
    throw;
  }
  return element;
}

void Network::set_rest(ElementIndex index, std::vector<Vector3> rest, const Vector3& direction) {
  if (index >= elements_.size()) fail(fmt::format("there is no element {}, only {}", index, elements_.size()));
  Element& element = elements_[index];
  const std::string what = fmt::format("an element of {}", name_of(element.invariant));
  if (!reads_several(element.invariant)) fail(fmt::format("{} has one reference value: use set_reference", what));
  if (rest.empty())
    for (const NodeIndex node : element.nodes) rest.push_back(nodes_[node].position);
  if (rest.size() != element.nodes.size())
    fail(fmt::format("{}: it has {} nodes, but {} positions at rest", what, element.nodes.size(), rest.size()));
  for (const Vector3& position : rest)
    if (!position.allFinite()) fail(fmt::format("{}: its positions at rest must be finite numbers", what));
  if (!direction.allFinite()) fail(fmt::format("{}: its direction must have finite numbers", what));
  Vector3 along = Vector3::Zero();
  if (direction != Vector3::Zero()) {
    along = to_unit(direction);
    if (rest.size() == 3) {
      const Vector3 normal = (rest[1] - rest[0]).cross(rest[2] - rest[0]).stableNormalized();
      constexpr double rounding = 8.0 * std::numeric_limits<double>::epsilon();
      const double out = normal.dot(along);
      if (std::abs(out) > rounding) along -= out * normal;
      constexpr double least = 1e-6;  // sine of the angle to the normal: below it the plane's direction is rounding
      if (!(along.norm() > least)) fail(fmt::format("{}: its direction is normal to it: give one in its plane", what));
      along = to_unit(along);
    }
  }
  const auto p = [&rest](std::size_t k) -> invariants::Point { return {rest[k][0], rest[k][1], rest[k][2]}; };
  element.reference = value_at(element.invariant, p(0), p(1), p(2), rest.size() > 3 ? p(3) : p(2));
  element.rest = std::move(rest);
  element.direction = along;
}

ElementIndex Network::add_checked(Invariant invariant, std::vector<NodeIndex> nodes, MaterialIndex material,
                                  std::optional<double> reference) {
  if (elements_.size() >= max_count) fail(fmt::format("a network has at most {} elements", max_count));
  const std::string what = fmt::format("an element of {}", name_of(invariant));
  const std::size_t wanted = corners_of(invariant);
  if (wanted > 0 ? nodes.size() != wanted : nodes.size() < 12 || nodes.size() % 3 != 0) {
    fail(fmt::format("{} has {} nodes, needs {}", what, nodes.size(),
                     wanted > 0 ? std::to_string(wanted) : "three for each triangle, of four triangles or more"));
  }
  for (const NodeIndex node : nodes) {
    if (node >= nodes_.size()) fail(fmt::format("{}: there is no node {}, only {}", what, node, nodes_.size()));
  }
  const std::size_t corners = wanted > 0 ? wanted : 3;
  for (std::size_t begin = 0; begin < nodes.size(); begin += corners) {
    for (std::size_t i = begin; i < begin + corners; ++i) {
      for (std::size_t j = begin; j < i; ++j) {
        if (nodes[i] == nodes[j]) {
          fail(fmt::format("{}: it has node {} twice: give different nodes", what, nodes[i]));
        }
      }
    }
  }
  if (wanted == 0) check_closed(nodes);
  check_material(material);
  Element element{invariant, std::move(nodes), material, 0.0};
  element.reference = reference ? *reference : value_of(element);
  if (!std::isfinite(element.reference)) {
    fail(fmt::format("{}: its reference must be a finite number, is {}", what, element.reference));
  }
  elements_.push_back(std::move(element));
  return static_cast<ElementIndex>(elements_.size() - 1);
}

void Network::set_reference(ElementIndex element, double reference) {
  if (element >= elements_.size()) fail(fmt::format("there is no element {}, only {}", element, elements_.size()));
  if (reads_several(elements_[element].invariant)) {
    fail(fmt::format("element {} ({}) has several reference values: use set_rest", element,
                     name_of(elements_[element].invariant)));
  }
  if (!std::isfinite(reference)) {
    fail(fmt::format("the reference of an element must be a finite number, is {}", reference));
  }
  elements_[element].reference = reference;
}

double Network::value_of(const Element& element) const {
  const auto p = [&](std::size_t k) -> invariants::Point {
    const Vector3& at = nodes_[element.nodes[k]].position;
    return {at[0], at[1], at[2]};
  };
  if (element.invariant != Invariant::enclosed_volume)
    return value_at(element.invariant, p(0), p(1), p(2), corners_of(element.invariant) > 3 ? p(3) : p(2));
  // Relative to a node of the surface: far from the origin the sum would lose significant digits.
  const invariants::Point origin = p(0);
  double sum = 0.0;
  for (std::size_t k = 0; k < element.nodes.size(); k += 3)
    sum += dot(p(k) - origin, cross(p(k + 1) - origin, p(k + 2) - origin));
  return sum / 6.0;
}

void Network::add_face(const Face& face) {
  for (const NodeIndex node : face) {
    if (node >= nodes_.size()) fail(fmt::format("a face: there is no node {}, only {}", node, nodes_.size()));
  }
  if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) {
    fail(fmt::format("a face of nodes {}, {} and {}: give three different nodes", face[0], face[1], face[2]));
  }
  faces_.push_back(face);
}

void Network::add_group(const std::string& name, std::vector<NodeIndex> nodes) {
  if (!in_body_) fail(fmt::format("group '{}' is outside of a body: add it between begin_body and end_body", name));
  Body& body = bodies_.back();
  if (name.empty()) fail(fmt::format("body '{}': a group needs a name", body.name));
  if (body.groups.empty()) group_names_.clear();
  if (group_names_.contains(name)) {
    fail(fmt::format("body '{}': there are two groups '{}': rename one", body.name, name));
  }
  for (const NodeIndex node : nodes) {
    if (node < body.first_node || node >= nodes_.size()) {
      fail(fmt::format("body '{}', group '{}': node {} is not one of the body", body.name, name, node));
    }
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  group_names_.insert(name);
  body.groups.push_back({name, std::move(nodes)});
}

}  // namespace springnet
