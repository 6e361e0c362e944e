#include "proximity/primitives.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet::proximity {

namespace {

constexpr Group most_groups = 4096;  // a table of all pairs then takes 6 MB

template <class Primitive>
void check_primitive(const Primitive& primitive, const char* kind, std::size_t number) {
  if (!(primitive.radius >= 0.0) || !std::isfinite(primitive.radius))
    throw Error(ErrorKind::input, fmt::format("{} {} of a contact has the radius {}; it must be finite and at least 0",
                                              kind, number, primitive.radius));
  if (primitive.group >= most_groups)
    throw Error(ErrorKind::input, fmt::format("{} {} of a contact is in group {}; groups are numbered from 0 to {}",
                                              kind, number, primitive.group, most_groups - 1));
}

template <class Nodes>
void check_distinct(const Nodes& nodes, const char* kind, std::size_t number) {
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (nodes[i] == nodes[j])
        throw Error(ErrorKind::input, fmt::format("{} {} of a contact has node {} twice", kind, number, nodes[i]));
}

}  // namespace

Primitives::Primitives(PrimitiveLists lists) : lists_(std::move(lists)) {
  std::size_t number = 0;
  for (const Ball& ball : lists_.balls) {
    check_primitive(ball, "ball", number++);
    nodes_.push_back(ball.node);
  }
  std::sort(nodes_.begin(), nodes_.end());
  if (const auto twice = std::adjacent_find(nodes_.begin(), nodes_.end()); twice != nodes_.end())
    throw Error(ErrorKind::input, fmt::format("node {} has two balls of a contact; it can have one", *twice));
  number = 0;
  for (const Edge& edge : lists_.edges) {
    check_primitive(edge, "edge", number);
    check_distinct(edge.nodes, "edge", number++);
    nodes_.insert(nodes_.end(), edge.nodes.begin(), edge.nodes.end());
  }
  number = 0;
  for (const Triangle& triangle : lists_.triangles) {
    check_primitive(triangle, "triangle", number);
    check_distinct(triangle.nodes, "triangle", number++);
    nodes_.insert(nodes_.end(), triangle.nodes.begin(), triangle.nodes.end());
  }
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
  nodes_.shrink_to_fit();
  for (auto& ends : lists_.joined)
    if (ends[0] > ends[1]) std::swap(ends[0], ends[1]);
  std::sort(lists_.joined.begin(), lists_.joined.end());
  collect_groups();
}

void Primitives::collect_groups() {
  const auto include = [this](Group group) { groups_ = std::max<std::size_t>(groups_, group + 1); };
  for (const Ball& ball : lists_.balls) include(ball.group);
  for (const Edge& edge : lists_.edges) include(edge.group);
  for (const Triangle& triangle : lists_.triangles) include(triangle.group);
  for (const CheckedGroups& checked : lists_.checked) {
    if (std::max(checked.a, checked.b) >= most_groups)
      throw Error(ErrorKind::input, fmt::format("groups {} and {} are checked for contact; groups are numbered from 0 "
                                                "to {}",
                                                checked.a, checked.b, most_groups - 1));
    include(checked.a);
    include(checked.b);
  }
  partners_.assign(3 * groups_, std::vector<std::uint64_t>(groups_ / 64 + 1, 0));
  masks_.assign(3 * groups_, 0);
  const auto set = [this](PairKind kind, Group a, Group b) {
    partners_[index(kind, a)][b / 64] |= std::uint64_t{1} << (b % 64);
    masks_[index(kind, a)] |= std::uint32_t{1} << (b % 32);
  };
  for (const CheckedGroups& checked : lists_.checked)
    for (const PairKind kind : pair_kinds)
      if (kind == PairKind::node_node       ? checked.node_node
          : kind == PairKind::node_triangle ? checked.node_triangle
                                            : checked.edge_edge) {
        checks_any_[static_cast<std::size_t>(kind)] = true;
        set(kind, checked.a, checked.b);
        set(kind, checked.b, checked.a);
      }
}

bool Primitives::are_joined(NodeIndex a, NodeIndex b) const {
  return std::binary_search(lists_.joined.begin(), lists_.joined.end(),
                            std::array<NodeIndex, 2>{std::min(a, b), std::max(a, b)});
}

bool Primitives::may_touch(PairKind kind, Pair pair) const {
  switch (kind) {
    case PairKind::node_node: {
      const Ball &a = lists_.balls[pair.first], &b = lists_.balls[pair.second];
      return checks(kind, a.group, b.group) && !are_joined(a.node, b.node);
    }
    case PairKind::node_triangle: {
      const Ball& ball = lists_.balls[pair.first];
      const Triangle& triangle = lists_.triangles[pair.second];
      const auto& corner = triangle.nodes;
      return ball.node != corner[0] && ball.node != corner[1] && ball.node != corner[2] &&
             checks(kind, ball.group, triangle.group);
    }
    case PairKind::edge_edge:
      break;
  }
  const Edge &a = lists_.edges[pair.first], &b = lists_.edges[pair.second];
  return a.nodes[0] != b.nodes[0] && a.nodes[0] != b.nodes[1] && a.nodes[1] != b.nodes[0] && a.nodes[1] != b.nodes[1] &&
         checks(kind, a.group, b.group);
}

double Primitives::thickness(PairKind kind, Pair pair) const {
  switch (kind) {
    case PairKind::node_node:
      return lists_.balls[pair.first].radius + lists_.balls[pair.second].radius;
    case PairKind::node_triangle:
      return lists_.balls[pair.first].radius + lists_.triangles[pair.second].radius;
    case PairKind::edge_edge:
      break;
  }
  return lists_.edges[pair.first].radius + lists_.edges[pair.second].radius;
}

std::array<NodeIndex, 4> Primitives::nodes_of(PairKind kind, Pair pair) const {
  switch (kind) {
    case PairKind::node_node: {
      const NodeIndex p = lists_.balls[pair.first].node;
      return {p, lists_.balls[pair.second].node, p, p};
    }
    case PairKind::node_triangle: {
      const auto& corner = lists_.triangles[pair.second].nodes;
      return {lists_.balls[pair.first].node, corner[0], corner[1], corner[2]};
    }
    case PairKind::edge_edge:
      break;
  }
  const auto& a = lists_.edges[pair.first].nodes;
  const auto& b = lists_.edges[pair.second].nodes;
  return {a[0], a[1], b[0], b[1]};
}

std::array<Vector3, 4> Primitives::corners(PairKind kind, Pair pair, const Positions& x) const {
  const auto node = nodes_of(kind, pair);
  return {x[node[0]], x[node[1]], x[node[2]], x[node[3]]};
}

std::vector<Edge> edges_of(std::span<const Triangle> triangles) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const NodeIndex a = triangle.nodes[i], b = triangle.nodes[(i + 1) % 3];
      edges.push_back({{std::min(a, b), std::max(a, b)}, triangle.radius, triangle.group});
    }
  std::stable_sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.nodes < b.nodes; });
  edges.erase(std::unique(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.nodes == b.nodes; }),
              edges.end());
  return edges;
}

std::vector<Ball> corners_of(std::span<const Triangle> triangles) {
  std::vector<Ball> balls;
  balls.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles)
    for (const NodeIndex node : triangle.nodes) balls.push_back({node, triangle.radius, triangle.group});
  std::stable_sort(balls.begin(), balls.end(), [](const Ball& a, const Ball& b) { return a.node < b.node; });
  balls.erase(std::unique(balls.begin(), balls.end(), [](const Ball& a, const Ball& b) { return a.node == b.node; }),
              balls.end());
  return balls;
}

}  // namespace springnet::proximity
