#include "proximity/crossings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "proximity/box_tree.hpp"
#include "proximity/orientation.hpp"
#include "proximity/pair_search.hpp"

namespace springnet::proximity {

namespace {

template <class Primitive>
BoxTree tree_around(const std::vector<Primitive>& items, const Positions& x) {
  std::vector<Box> boxes;
  std::vector<Group> groups;
  for (const Primitive& item : items) {
    boxes.push_back(Box::empty());
    for (const NodeIndex node : item.nodes) boxes.back().include(x[node]);
    groups.push_back(item.group);
  }
  BoxTree tree;
  tree.build(boxes, groups);
  return tree;
}

}  // namespace

bool crosses(const Vector3& p, const Vector3& q, const Vector3& a, const Vector3& b, const Vector3& c) {
  const int side = orientation(a, b, c, p);
  if (side == 0 || orientation(a, b, c, q) != -side) return false;
  // The line has all three edges of the triangle on one side, or passes through them.
  const std::array turns{orientation(p, q, a, b), orientation(p, q, b, c), orientation(p, q, c, a)};
  const auto [least, greatest] = std::minmax_element(turns.begin(), turns.end());
  return *least >= 0 || *greatest <= 0;
}

std::vector<Crossing> find_crossings(const Primitives& primitives, const Positions& x) {
  check_positions(primitives, x);
  const BoxTree edges = tree_around(primitives.edges(), x), triangles = tree_around(primitives.triangles(), x);
  std::vector<Crossing> found;
  const auto consider = [&](std::uint32_t e, std::uint32_t t) {
    const Edge& edge = primitives.edges()[e];
    const Triangle& triangle = primitives.triangles()[t];
    if (!primitives.checks(PairKind::edge_edge, edge.group, triangle.group) &&
        !primitives.checks(PairKind::node_triangle, edge.group, triangle.group))
      return;
    for (const NodeIndex node : edge.nodes)
      if (std::find(triangle.nodes.begin(), triangle.nodes.end(), node) != triangle.nodes.end()) return;
    if (crosses(x[edge.nodes[0]], x[edge.nodes[1]], x[triangle.nodes[0]], x[triangle.nodes[1]], x[triangle.nodes[2]]))
      found.push_back({e, t});
  };
  const auto partners = [&](Group group) {
    return primitives.partner_mask(PairKind::edge_edge, group) |
           primitives.partner_mask(PairKind::node_triangle, group);
  };
  Effort effort(Effort::of_search(primitives));
  BoxTree::for_overlaps(edges, 0, edges.leaves(), triangles, partners, effort, consider);
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace springnet::proximity
