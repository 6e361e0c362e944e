// The list beside a search at every step, for motions of all kinds.
#include "proximity/neighbour_list.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "proximity/near_pairs.hpp"
#include "random_pairs.hpp"
#include "surfaces.hpp"

using namespace springnet;
using namespace springnet::proximity;

namespace {

Surfaces sheet(double opening = 2e-3) {
  Surfaces surfaces;
  add_folded_sheet(surfaces, 20, 0.01, 5, opening, Vector3::Zero(), 5e-4, 0);
  return surfaces;
}

struct Touching {
  PairKind kind;
  Pair pair;
  bool operator==(const Touching&) const = default;
};

std::vector<Touching> touching(const Primitives& primitives, const PairLists& pairs, const Positions& x) {
  std::vector<NearPair> near;
  find_near(primitives, pairs, x, 0.0, near);
  std::vector<Touching> found;
  for (const NearPair& one : near) found.push_back({one.kind, one.pair});
  return found;
}

}  // namespace

TEST_CASE("all pairs that touch are in the list at each step, and searches are rare") {
  PairDice dice(21);
  Surfaces now = sheet(3e-4);
  const Primitives primitives(now.lists({{0, 0}}));
  NeighbourList list(primitives, 2e-3);
  PairSearch search(primitives);
  PairLists all;
  std::size_t touches = 0;
  for (int step = 0; step < 300; ++step) {
    // A fall of all, and steps of each node by chance of a 30th of the skin.
    Surfaces next = now;
    for (NodeIndex node = 0; node < next.x[0].size(); ++node)
      next.set(node, now.positions()[node] + Vector3(0, 0, -0.05) + dice.vector(4e-5));
    list.update(now.positions(), next.positions());
    CHECK(list.covers(next.positions()));
    search.find(next.positions(), 0.0, all);
    const auto expected = touching(primitives, all, next.positions());
    CHECK(touching(primitives, list.pairs(), next.positions()) == expected);
    touches += expected.size();
    now = next;
  }
  CHECK(touches > 3000);
  // Nodes by chance are half of the skin, 1e-3 m, from where they were after some 600 steps of 4e-5 m; the fall, of 25
  // skins each step, does not count.
  CHECK(list.searches() >= 1);
  CHECK(list.searches() < 30);
}

TEST_CASE("a list holds until two nodes have moved towards each other by the skin") {
  const Surfaces start = sheet();
  NeighbourList list(Primitives(start.lists({{0, 0}})), 2e-3);
  CHECK(!list.covers(start.positions()));
  CHECK(list.update(start.positions()));
  CHECK(list.covers(start.positions()));
  Surfaces moved = start;
  for (auto& z : moved.x[2]) z += 1e6;
  CHECK(list.covers(moved.positions()));  // all together, 1e6 m
  moved = start;
  moved.x[0][7] += 1.99e-3;
  CHECK(list.covers(moved.positions()));  // one of them, by less than the skin
  moved.x[0][7] += 0.02e-3;
  CHECK(!list.covers(moved.positions()));
  moved = start;
  moved.x[0][7] += 1.1e-3;
  moved.x[0][8] -= 1.1e-3;
  CHECK(!list.covers(moved.positions()));
  // Along different axes, at most half of the skin each: the diagonal of their box is longer.
  moved = start;
  for (std::size_t k = 0; k < 3; ++k) {
    moved.x[k][7 + 2 * k] += 0.99e-3;
    moved.x[k][8 + 2 * k] -= 0.99e-3;
  }
  CHECK(list.covers(moved.positions()));
  moved.x[1][40] = std::numeric_limits<double>::quiet_NaN();
  CHECK(!list.covers(moved.positions()));
  CHECK_THROWS_AS(list.update(moved.positions()), Error);
  CHECK(list.pairs().size() == 0);
  CHECK(list.update(start.positions()));
  CHECK(!list.update(start.positions()));
  list.forget();
  CHECK(list.update(start.positions()));
}

TEST_CASE("a step farther than the skin is searched with its motion") {
  // A ball flies through a sheet, by a hundred thicknesses.
  Surfaces start = sheet();
  const NodeIndex ball = start.add({0.011, 0.1013, 0.2});
  PrimitiveLists lists = start.lists({{0, 1}});
  lists.balls.push_back({ball, 1e-3, 1});
  NeighbourList list(Primitives(lists), 1e-3);
  Surfaces end = start;
  end.set(ball, {0.011, 0.1013, -0.2});
  CHECK(list.update(start.positions(), end.positions()));
  std::vector<MeetingPair> met;
  find_meetings(list.primitives(), list.pairs(), start.positions(), end.positions(), met);
  REQUIRE(!met.empty());
  for (const MeetingPair& one : met) CHECK(one.kind == PairKind::node_triangle);
  for (std::size_t i = 0; i + 1 < met.size(); ++i) CHECK(met[i].meeting.time <= met[i + 1].meeting.time);
  CHECK(list.covers(end.positions()));
  CHECK(!list.update(end.positions(), end.positions()));
}

TEST_CASE("a skin must be positive") {
  const Surfaces surfaces = sheet();
  for (const double skin : {0.0, -1.0, std::numeric_limits<double>::infinity()})
    CHECK_THROWS_AS(NeighbourList(Primitives(surfaces.lists({{0, 0}})), skin), Error);
}
