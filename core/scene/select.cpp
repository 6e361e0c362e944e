#include "scene/select.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

// Points on the boundary are inside. Positions of lattices and mesh files are rounded, so the boundary has this
// tolerance, relative to the numbers compared. Far from the origin it could reach the next node, so it is limited to a
// small share of the shortest spring, but never below the rounding of the numbers themselves.
constexpr double tolerance = 1e-9, min_tolerance = 4.0 * std::numeric_limits<double>::epsilon();
constexpr double max_share = 1e-3;  // of the shortest spring

struct Region {
  std::vector<const Body*> bodies;  // in the order of their nodes; none: everywhere
  std::vector<SelectedGroup> groups;
  std::optional<std::vector<NodeIndex>> grouped;  // their nodes, ascending
  std::optional<Vector3> smallest, largest, center;
  double radius = 0;
  double max_tolerance = std::numeric_limits<double>::infinity();  // m, greatest tolerance of the boundary

  [[nodiscard]] bool has_shape() const { return smallest || largest || center; }
  [[nodiscard]] bool restricts() const { return has_shape() || grouped || !bodies.empty(); }

  [[nodiscard]] bool contains(NodeIndex node, const Vector3& p) const {
    if (!bodies.empty()) {
      const auto after = std::upper_bound(bodies.begin(), bodies.end(), node,
                                          [](NodeIndex n, const Body* body) { return n < body->first_node; });
      if (after == bodies.begin() || node - (*(after - 1))->first_node >= (*(after - 1))->node_count) return false;
    }
    if (grouped && !std::binary_search(grouped->begin(), grouped->end(), node)) return false;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (smallest && p[axis] < (*smallest)[axis] - tolerance_at((*smallest)[axis], p[axis])) return false;
      if (largest && p[axis] > (*largest)[axis] + tolerance_at((*largest)[axis], p[axis])) return false;
    }
    return !center || (p - *center).norm() <= radius + tolerance_at(center->norm() + radius, p.norm());
  }

 private:
  [[nodiscard]] double tolerance_at(double bound, double coordinate) const {
    if (!std::isfinite(bound)) return 0.0;
    const double number = std::max(std::abs(bound), std::abs(coordinate));
    return std::min(tolerance * number, std::max(max_tolerance, min_tolerance * number));
  }
};

// m, of springs with a length; infinity if there are none.
double shortest_spring(const Network& network) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const Spring& spring : network.springs()) {
    const double length = (network.nodes()[spring.first].position - network.nodes()[spring.second].position).norm();
    if (length > 0.0) shortest = std::min(shortest, length);
  }
  return shortest;
}

Vector3 corner(const Value& value) {
  const std::vector<Value> values = value.elements(3);
  return {values[0].coordinate(), values[1].coordinate(), values[2].coordinate()};
}

template <class Element>
void sort_and_unite(std::vector<Element>& elements) {
  std::sort(elements.begin(), elements.end());
  elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
}

// Adds the groups of this name of the bodies.
void add_group(const Value& name, const std::vector<const Body*>& bodies, const Network& network,
               std::vector<SelectedGroup>& groups) {
  const std::string wanted = name.text();
  const std::size_t before = groups.size();
  for (const Body* body : bodies) {
    for (std::size_t k = 0; k < body->groups.size(); ++k) {
      if (body->groups[k].name == wanted)
        groups.push_back({static_cast<std::size_t>(body - network.bodies().data()), k});
    }
  }
  if (groups.size() > before) return;
  std::vector<std::string> known;
  for (const Body* body : bodies) {
    for (const NodeGroup& group : body->groups) known.push_back(group.name);
  }
  const std::string where =
      bodies.size() == 1 ? fmt::format("body '{}'", printable(bodies.front()->name)) : "the bodies";
  if (known.empty()) {
    name.fail(fmt::format("there is no group '{}': {} {} no groups; they come from the named parts of a mesh file",
                          printable(wanted), where, bodies.size() == 1 ? "has" : "have"));
  }
  sort_and_unite(known);
  const std::string nearest = suggestion(wanted, known);
  name.fail(fmt::format("there is no group '{}' in {}{}{}; known: {}", printable(wanted), where,
                        nearest.empty() ? "" : "; ", nearest, list_of(known)));
}

// Groups of the given bodies, or of all if none are given.
std::vector<SelectedGroup> read_groups(const Value& value, std::vector<const Body*> bodies, const Network& network) {
  if (bodies.empty()) {
    for (const Body& body : network.bodies()) bodies.push_back(&body);
  }
  std::vector<SelectedGroup> groups;
  if (value.is_list()) {
    const std::vector<Value> names = value.elements();
    if (names.empty()) value.fail("names no group; leave the key out to select whole bodies");
    for (const Value& name : names) add_group(name, bodies, network, groups);
  } else {
    add_group(value, bodies, network, groups);
  }
  return groups;
}

std::vector<NodeIndex> nodes_of(const std::vector<SelectedGroup>& groups, const Network& network) {
  std::vector<NodeIndex> nodes;
  for (const auto& [body, group] : groups) {
    const std::vector<NodeIndex>& more = network.bodies()[body].groups[group].nodes;
    nodes.insert(nodes.end(), more.begin(), more.end());
  }
  sort_and_unite(nodes);
  return nodes;
}

Region read_region(const Table& table, const Network& network) {
  Region region;
  if (const auto body = table.find("body")) {
    if (body->is_list()) {
      for (const Value& name : body->elements()) region.bodies.push_back(&find_body(name, network));
      if (region.bodies.empty()) body->fail("names no body; leave the key out to select from all of them");
      std::sort(region.bodies.begin(), region.bodies.end());  // of one array, in the order of their nodes
    } else {
      region.bodies.push_back(&find_body(*body, network));
    }
  }
  if (const auto groups = table.find("group")) {
    region.groups = read_groups(*groups, region.bodies, network);
    region.grouped = nodes_of(region.groups, network);
  }
  if (const auto value = table.find("box")) {
    const Table box = value->table("select.box");
    if (const auto smallest = box.find("min")) region.smallest = corner(*smallest);
    if (const auto largest = box.find("max")) region.largest = corner(*largest);
    if (!region.smallest && !region.largest) box.fail("needs 'min', 'max' or both: three numbers [x, y, z], m");
    if (region.smallest && region.largest && (region.smallest->array() > region.largest->array()).any()) {
      box.fail("'min' must not be above 'max' in any coordinate; exchange them");
    }
  }
  if (const auto value = table.find("sphere")) {
    const Table sphere = value->table("select.sphere");
    region.center = sphere.need("center").vector();
    region.radius = sphere.need("radius").number_above_0("m");
  }
  if (region.has_shape()) region.max_tolerance = max_share * shortest_spring(network);
  return region;
}

// The body within which numbers count; null: numbers of the whole network.
const Body* body_of_numbers(const Value& numbers, const Region& region) {
  if (region.bodies.size() > 1) {
    numbers.fail("numbers count within one body; name one body, or none for the numbers of the whole network");
  }
  return region.bodies.empty() ? nullptr : region.bodies.front();
}

template <class Index>
std::vector<Index> range(Index first, Index count) {
  std::vector<Index> indices(count);
  std::iota(indices.begin(), indices.end(), first);
  return indices;
}

// Nodes that satisfy all keys except `springs`; may be empty.
std::vector<NodeIndex> nodes_in(const Table& table, const Region& region, const Network& network) {
  std::vector<NodeIndex> candidates;
  if (const auto numbers = table.find("nodes")) {
    const Body* body = body_of_numbers(*numbers, region);
    for (const Value& number : numbers->elements()) candidates.push_back(read_node(number, body, network));
    sort_and_unite(candidates);
  } else if (region.grouped) {
    candidates = *region.grouped;
  } else if (region.bodies.size() == 1) {
    candidates = range(region.bodies.front()->first_node, region.bodies.front()->node_count);
  } else {
    candidates = range(NodeIndex{0}, static_cast<NodeIndex>(network.nodes().size()));
  }
  std::erase_if(candidates, [&](NodeIndex node) { return !region.contains(node, network.nodes()[node].position); });
  return candidates;
}

SpringIndex read_spring(const Value& number, const Body* body, const Network& network) {
  const std::size_t count = body != nullptr ? body->spring_count : network.springs().size();
  const std::int64_t index = number.integer(0);
  if (index >= static_cast<std::int64_t>(count)) {
    const std::string where = body != nullptr ? fmt::format("body '{}'", printable(body->name)) : "the network";
    number.fail(fmt::format("there is no spring {} in {}, it has {}, numbered from 0", index, where, count));
  }
  return static_cast<SpringIndex>(index) + (body != nullptr ? body->first_spring : 0);
}

// A hint for empty selections: the extent of the nodes.
std::string extent_of(const Region& region, const Network& network) {
  if (!region.has_shape() || network.nodes().empty()) return "; check the numbers";
  Vector3 low = network.nodes()[0].position, high = low;
  for (const Node& node : network.nodes()) {
    low = low.cwiseMin(node.position);
    high = high.cwiseMax(node.position);
  }
  return fmt::format("; move or widen the region: the nodes of the scene lie between [{}, {}, {}] and [{}, {}, {}]",
                     low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
}

}  // namespace

std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t max_shown = 20;
  std::string list;
  for (std::size_t k = 0; k < std::min(names.size(), max_shown); ++k) {
    list += (k == 0 ? "" : ", ") + printable(names[k]);
  }
  if (names.size() > max_shown) list += fmt::format(", and {} more", names.size() - max_shown);
  return list;
}

const Body& find_body(const Value& name, const Network& network) {
  const std::string wanted = name.text();
  for (const Body& body : network.bodies()) {
    if (body.name == wanted) return body;
  }
  std::vector<std::string> known;
  for (const Body& body : network.bodies()) known.push_back(body.name);
  const std::string nearest = suggestion(wanted, known);
  name.fail(fmt::format("there is no body '{}'; {}", printable(wanted),
                        nearest.empty() ? "write the name of a [[body]]" : nearest));
}

NodeIndex read_node(const Value& number, const Body* body, const Network& network) {
  const std::size_t count = body != nullptr ? body->node_count : network.nodes().size();
  const std::int64_t index = number.integer(0);
  if (index >= static_cast<std::int64_t>(count)) {
    const std::string where = body != nullptr ? fmt::format("body '{}'", printable(body->name)) : "the network";
    number.fail(fmt::format("there is no node {} in {}, it has {}, numbered from 0", index, where, count));
  }
  return static_cast<NodeIndex>(index) + (body != nullptr ? body->first_node : 0);
}

void count_selected(const Value& selection, std::size_t count, std::size_t& total) {
  constexpr std::size_t most = 100'000'000;
  total += count;
  if (total <= most) return;
  selection.fail(
      fmt::format("brings the total that tables of this kind select to {}, but at most {} are allowed; select less, or "
                  "merge similar tables",
                  grouped(total), grouped(most)));
}

std::vector<SelectedGroup> select_groups(const Value& selection, const Network& network) {
  return read_region(selection.table("select"), network).groups;
}

std::vector<NodeIndex> select_nodes(const Value& selection, const Network& network) {
  const Table table = selection.table("select");
  if (const auto springs = table.find("springs")) {
    springs->fail("nodes are selected here, not springs; write 'nodes', or select by 'body', 'box' or 'sphere'");
  }
  const Region region = read_region(table, network);
  std::vector<NodeIndex> nodes = nodes_in(table, region, network);
  if (nodes.empty()) selection.fail("selects no node" + extent_of(region, network));
  return nodes;
}

std::vector<SpringIndex> select_springs(const Value& selection, const Network& network) {
  const Table table = selection.table("select");
  const Region region = read_region(table, network);
  std::vector<SpringIndex> springs;
  if (const auto numbers = table.find("springs")) {
    const Body* body = body_of_numbers(*numbers, region);
    for (const Value& number : numbers->elements()) springs.push_back(read_spring(number, body, network));
    sort_and_unite(springs);
  } else {
    springs = range(SpringIndex{0}, static_cast<SpringIndex>(network.springs().size()));
  }
  if (region.restricts() || table.has("nodes")) {
    std::vector<bool> inside(network.nodes().size(), false);
    for (const NodeIndex node : nodes_in(table, region, network)) inside[node] = true;
    std::erase_if(springs, [&](SpringIndex index) {
      const Spring& spring = network.springs()[index];
      return !inside[spring.first] || !inside[spring.second];
    });
  }
  if (springs.empty()) {
    selection.fail("selects no spring (both ends must match the selection)" + extent_of(region, network));
  }
  return springs;
}

}  // namespace springnet::scene
