// What contact is detected between: nodes as balls, edges and triangles of surfaces that are thick. Each belongs to a
// group; pairs of groups say what is checked against what. Distances are those of nodes, segments and triangles
// themselves; two primitives touch where their distance is the sum of their radii, the *thickness* of the pair.
//
// Excluded are pairs that share a node, and pairs of balls that a spring joins: these are near each other by
// construction, and the springs already act between them. A ball is checked against a triangle one of whose corners a
// spring joins to it: excluding these would let a sheet's node pass through triangles two springs away. Choose a
// thickness below the rest distances of a surface, so that such pairs do not touch at rest.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <springnet/network_lists.hpp>

namespace springnet::proximity {

using Group = std::uint32_t;

// Components of the positions of all nodes, m; [nodes] each.
struct Positions {
  const double* x[3];
  std::size_t nodes;

  [[nodiscard]] Vector3 operator[](NodeIndex node) const { return {x[0][node], x[1][node], x[2][node]}; }
};

struct Ball {
  NodeIndex node;
  double radius;  // m, >= 0
  Group group;
};

struct Edge {
  std::array<NodeIndex, 2> nodes;
  double radius;  // m, >= 0: half the thickness of the surface
  Group group;
};

struct Triangle {
  std::array<NodeIndex, 3> nodes;
  double radius;  // m, >= 0: half the thickness of the surface
  Group group;
};

enum class PairKind : std::uint8_t { node_node, node_triangle, edge_edge };
inline constexpr std::array pair_kinds{PairKind::node_node, PairKind::node_triangle, PairKind::edge_edge};

// How many nodes the first and the second primitive of a pair have. Where four values belong to the nodes of a pair,
// those of the first come first.
[[nodiscard]] constexpr int first_nodes(PairKind kind) noexcept { return kind == PairKind::edge_edge ? 2 : 1; }
[[nodiscard]] constexpr int second_nodes(PairKind kind) noexcept {
  return kind == PairKind::node_node ? 1 : kind == PairKind::edge_edge ? 2 : 3;
}

// Indices of two primitives: of balls and edges first < second; of a ball and a triangle in this order.
struct Pair {
  std::uint32_t first, second;
  auto operator<=>(const Pair&) const = default;
};

// Pairs of each kind, ordered by `first`, then by `second`.
struct PairLists {
  std::array<std::vector<Pair>, 3> of_kind;

  [[nodiscard]] std::vector<Pair>& operator[](PairKind kind) { return of_kind[static_cast<std::size_t>(kind)]; }
  [[nodiscard]] const std::vector<Pair>& operator[](PairKind kind) const {
    return of_kind[static_cast<std::size_t>(kind)];
  }
  [[nodiscard]] std::size_t size() const noexcept { return of_kind[0].size() + of_kind[1].size() + of_kind[2].size(); }
};

// Two groups, or one with itself, and the kinds of pairs that are checked between them. Corners of triangles are in
// node_triangle already: choose node_node only for balls that no surface covers.
struct CheckedGroups {
  Group a, b;
  bool node_node = false, node_triangle = true, edge_edge = true;
};

struct PrimitiveLists {
  std::vector<Ball> balls;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  std::vector<CheckedGroups> checked;
  std::vector<std::array<NodeIndex, 2>> joined;  // ends of springs: balls at these do not touch
};

class Primitives {
 public:
  // Throws Error (input) for a primitive with a node twice, a radius that is negative or not finite, a node of two
  // balls, a group of 4096 or more.
  explicit Primitives(PrimitiveLists lists);

  [[nodiscard]] const std::vector<Ball>& balls() const noexcept { return lists_.balls; }
  [[nodiscard]] const std::vector<Edge>& edges() const noexcept { return lists_.edges; }
  [[nodiscard]] const std::vector<Triangle>& triangles() const noexcept { return lists_.triangles; }
  // Nodes of all primitives, ascending, each once.
  [[nodiscard]] const std::vector<NodeIndex>& nodes() const noexcept { return nodes_; }

  [[nodiscard]] bool checks(PairKind kind, Group a, Group b) const {
    return (partners_[index(kind, a)][b / 64] >> (b % 64) & 1) != 0;
  }
  // Bit g % 32 is set if a group g is checked against this one.
  [[nodiscard]] std::uint32_t partner_mask(PairKind kind, Group group) const { return masks_[index(kind, group)]; }
  [[nodiscard]] bool checks_any(PairKind kind) const { return checks_any_[static_cast<std::size_t>(kind)]; }
  // Their groups are checked, they share no node and, if they are balls, no spring joins them.
  [[nodiscard]] bool may_touch(PairKind kind, Pair pair) const;

  [[nodiscard]] double thickness(PairKind kind, Pair pair) const;  // m
  // Numbers and positions (m) of the nodes of a pair; unused places are those of the first node.
  [[nodiscard]] std::array<NodeIndex, 4> nodes_of(PairKind kind, Pair pair) const;
  [[nodiscard]] std::array<Vector3, 4> corners(PairKind kind, Pair pair, const Positions& x) const;

 private:
  [[nodiscard]] std::size_t index(PairKind kind, Group group) const {
    return static_cast<std::size_t>(kind) * groups_ + group;
  }
  [[nodiscard]] bool are_joined(NodeIndex a, NodeIndex b) const;
  void collect_groups();

  PrimitiveLists lists_;
  std::vector<NodeIndex> nodes_;
  std::size_t groups_ = 0;
  std::vector<std::vector<std::uint64_t>> partners_;  // [kind, group]: a bit for each group
  std::vector<std::uint32_t> masks_;                  // [kind, group]
  std::array<bool, 3> checks_any_{};
};

// Each edge of the triangles once, in ascending order, with radius and group of the first triangle that has it.
[[nodiscard]] std::vector<Edge> edges_of(std::span<const Triangle> triangles);
// Each corner of the triangles once, likewise.
[[nodiscard]] std::vector<Ball> corners_of(std::span<const Triangle> triangles);

}  // namespace springnet::proximity
