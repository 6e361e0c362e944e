// What primitives are checked against each other, and what is refused.
#include "proximity/primitives.hpp"

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

using namespace springnet;
using namespace springnet::proximity;

namespace {

PrimitiveLists two_triangles() {
  const std::vector<Triangle> triangles{{{0, 1, 2}, 0.1, 0}, {{1, 3, 2}, 0.1, 0}, {{4, 5, 6}, 0.2, 1}};
  return {corners_of(triangles), edges_of(triangles), triangles, {{0, 0, true}, {0, 1, false, true, false}}, {{3, 0}}};
}

}  // namespace

TEST_CASE("edges and corners of triangles are there once, in ascending order") {
  const PrimitiveLists lists = two_triangles();
  REQUIRE(lists.edges.size() == 8);
  CHECK(lists.edges[2].nodes == std::array<NodeIndex, 2>{1, 2});  // of both triangles
  for (std::size_t i = 0; i + 1 < lists.edges.size(); ++i) CHECK(lists.edges[i].nodes < lists.edges[i + 1].nodes);
  CHECK(lists.edges[7].group == 1);
  REQUIRE(lists.balls.size() == 7);
  CHECK(lists.balls[6].radius == 0.2);
}

TEST_CASE("groups, common nodes and springs decide what may touch") {
  const Primitives primitives(two_triangles());
  CHECK(!primitives.may_touch(PairKind::node_triangle, {1, 0}));  // a corner
  CHECK(primitives.may_touch(PairKind::node_triangle, {3, 0}));
  CHECK(primitives.may_touch(PairKind::node_triangle, {3, 2}));
  CHECK(primitives.may_touch(PairKind::node_triangle, {4, 0}));  // either way round
  CHECK(primitives.may_touch(PairKind::node_node, {1, 2}));
  CHECK(!primitives.may_touch(PairKind::node_node, {0, 3}));  // joined by a spring
  CHECK(!primitives.may_touch(PairKind::node_node, {0, 4}));  // not of these groups
  CHECK(!primitives.may_touch(PairKind::edge_edge, {0, 1}));  // a common node
  CHECK(primitives.may_touch(PairKind::edge_edge, {0, 4}));   // (0, 1) and (2, 3)
  CHECK(!primitives.may_touch(PairKind::edge_edge, {0, 5}));
  CHECK(primitives.partner_mask(PairKind::node_node, 0) == 1);
  CHECK(primitives.partner_mask(PairKind::node_triangle, 0) == 3);
  CHECK(primitives.partner_mask(PairKind::node_triangle, 1) == 1);
  CHECK(primitives.thickness(PairKind::node_triangle, {0, 2}) == 0.1 + 0.2);
  CHECK(primitives.nodes_of(PairKind::edge_edge, {0, 7}) == std::array<NodeIndex, 4>{0, 1, 5, 6});
  CHECK(primitives.nodes() == std::vector<NodeIndex>{0, 1, 2, 3, 4, 5, 6});
}

TEST_CASE("primitives that make no sense are refused") {
  const auto refused = [](const PrimitiveLists& lists) { CHECK_THROWS_AS(Primitives{lists}, Error); };
  PrimitiveLists lists = two_triangles();
  lists.triangles[1].nodes = {1, 2, 1};
  refused(lists);
  lists = two_triangles();
  lists.edges[3].radius = -0.1;
  refused(lists);
  lists.edges[3].radius = std::numeric_limits<double>::quiet_NaN();
  refused(lists);
  lists = two_triangles();
  lists.balls.push_back(lists.balls.front());
  refused(lists);
  lists = two_triangles();
  lists.checked.push_back({0, 4096});
  refused(lists);
  lists = two_triangles();
  lists.balls[0].group = 4000000000;
  refused(lists);
  CHECK_NOTHROW(Primitives{PrimitiveLists{}});
}
