// The search beside all pairs, one by one; and what must not make it slow, large or wrong.
#include "proximity/pair_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "proximity/distance.hpp"
#include "proximity/near_pairs.hpp"
#include "random_pairs.hpp"
#include "surfaces.hpp"

using namespace springnet;
using namespace springnet::proximity;

namespace {

// Balls, edges and triangles by chance, in three groups.
struct Cloud {
  Surfaces surfaces;
  PrimitiveLists lists;
};

Cloud cloud(PairDice& dice, int nodes, double size) {
  Cloud made;
  for (int i = 0; i < nodes; ++i) made.surfaces.add(dice.vector(size));
  const auto node = [&] { return static_cast<NodeIndex>(dice.whole(0, nodes - 1)); };
  const auto group = [&] { return static_cast<Group>(dice.whole(0, 2)); };
  const auto radius = [&] { return dice.number(0.0, 0.02); };
  for (int i = 0; i < nodes; ++i) made.lists.balls.push_back({static_cast<NodeIndex>(i), radius(), group()});
  for (int i = 0; i < nodes; ++i) {
    const NodeIndex a = node(), b = node(), c = node();
    if (a != b) made.lists.edges.push_back({{a, b}, radius(), group()});
    if (a != b && b != c && a != c) made.lists.triangles.push_back({{a, b, c}, radius(), group()});
  }
  made.lists.checked = {{0, 0, true}, {0, 1, true}, {2, 1, true, false, true}, {2, 2, false, true, false}};
  for (int i = 0; i < nodes; ++i) made.lists.joined.push_back({node(), node()});
  return made;
}

std::size_t count_of(const Primitives& primitives, PairKind kind, bool first) {
  if (kind == PairKind::edge_edge) return primitives.edges().size();
  return kind == PairKind::node_triangle && !first ? primitives.triangles().size() : primitives.balls().size();
}

template <class Wanted>
PairLists all_pairs(const Primitives& primitives, const Wanted& wanted) {
  PairLists found;
  for (const PairKind kind : pair_kinds)
    for (std::uint32_t i = 0; i < count_of(primitives, kind, true); ++i)
      for (std::uint32_t j = kind == PairKind::node_triangle ? 0 : i + 1; j < count_of(primitives, kind, false); ++j)
        if (primitives.may_touch(kind, {i, j}) && wanted(kind, Pair{i, j})) found[kind].push_back({i, j});
  return found;
}

PairLists found_by(PairSearch& search, const Positions& start, const Positions& end, double margin) {
  PairLists found;
  search.find(start, end, margin, found);
  return found;
}

}  // namespace

TEST_CASE("the search finds the pairs within the margin, all of them, in canonical order") {
  PairDice dice(11);
  std::size_t found_in_all = 0;
  for (int round = 0; round < 30; ++round) {
    Cloud made = cloud(dice, 60, round % 2 == 0 ? 1.0 : 0.3);
    const Primitives primitives(made.lists);
    PairSearch search(primitives);
    // The first search builds the trees, the others fit them to other places.
    for (int again = 0; again < 3; ++again) {
      const double margin = dice.number(0.0, 0.1);
      const Positions x = made.surfaces.positions();
      const PairLists expected = all_pairs(primitives, [&](PairKind kind, Pair pair) {
        return separation(kind, primitives.corners(kind, pair, x)).distance <=
               primitives.thickness(kind, pair) + margin;
      });
      const PairLists found = found_by(search, x, x, margin);
      CHECK(found.of_kind == expected.of_kind);
      found_in_all += found.size();
      for (NodeIndex node = 0; node < 60; ++node) made.surfaces.set(node, dice.vector(0.5));
    }
  }
  CHECK(found_in_all > 10000);
}

TEST_CASE("a search over a motion finds what comes near on the way") {
  PairDice dice(12);
  for (int round = 0; round < 20; ++round) {
    Cloud made = cloud(dice, 40, 1.0), moved = made;
    const Primitives primitives(made.lists);
    // A fast motion of all, and a lesser one of each.
    const Vector3 common = dice.vector(100.0);
    for (NodeIndex node = 0; node < 40; ++node)
      moved.surfaces.set(node, made.surfaces.positions()[node] + common + dice.vector(0.3));
    const Positions start = made.surfaces.positions(), end = moved.surfaces.positions();
    constexpr double margin = 0.01;
    const PairLists expected = all_pairs(primitives, [&](PairKind kind, Pair pair) {
      const auto from = primitives.corners(kind, pair, start), to = primitives.corners(kind, pair, end);
      for (int i = 0; i <= 100; ++i) {
        std::array<Vector3, 4> x;
        for (std::size_t k = 0; k < 4; ++k) x[k] = from[k] + (i / 100.0) * (to[k] - from[k]);
        if (separation(kind, x).distance <= primitives.thickness(kind, pair) + margin) return true;
      }
      return false;
    });
    PairSearch search(primitives);
    const PairLists found = found_by(search, start, end, margin);
    for (const PairKind kind : pair_kinds)
      CHECK(std::includes(found[kind].begin(), found[kind].end(), expected[kind].begin(), expected[kind].end()));
    // Not much more than these: without the common motion, of 100 m, as good as all pairs would be.
    const PairLists all = all_pairs(primitives, [](PairKind, Pair) { return true; });
    CHECK(found.size() < 3 * all.size() / 4);
  }
}

TEST_CASE("pairs do not depend on the order in which primitives are given") {
  Surfaces surfaces;
  add_folded_sheet(surfaces, 24, 0.01, 6, 1e-3, Vector3::Zero(), 5e-4, 0);
  const PrimitiveLists lists = surfaces.lists({{0, 0}});
  PrimitiveLists shuffled = lists;
  std::vector<std::uint32_t> place(lists.edges.size());
  std::iota(place.begin(), place.end(), 0U);
  std::shuffle(place.begin(), place.end(), std::mt19937(7));
  for (std::size_t i = 0; i < place.size(); ++i) shuffled.edges[i] = lists.edges[place[i]];
  const Primitives one(lists), other(shuffled);
  PairSearch search(one), search_shuffled(other);
  const Positions x = surfaces.positions();
  const PairLists found = found_by(search, x, x, 1e-3);
  PairLists back = found_by(search_shuffled, x, x, 1e-3);
  for (Pair& pair : back[PairKind::edge_edge]) {
    pair = {place[pair.first], place[pair.second]};
    if (pair.first > pair.second) std::swap(pair.first, pair.second);
  }
  std::sort(back[PairKind::edge_edge].begin(), back[PairKind::edge_edge].end());
  CHECK(found.size() > 1000);
  CHECK(found.of_kind == back.of_kind);
}

TEST_CASE("pairs, distances and meetings are the same bits for every number of threads") {
  Surfaces surfaces;
  add_folded_sheet(surfaces, 80, 0.01, 10, 5e-4, Vector3::Zero(), 5e-4, 0);
  Surfaces end = surfaces;
  PairDice dice(14);
  for (NodeIndex node = 0; node < end.x[0].size(); ++node)
    end.set(node, surfaces.positions()[node] + dice.vector(1e-3));
  const Primitives primitives(surfaces.lists({{0, 0}}));
  PairLists pairs;
  std::vector<NearPair> near;
  std::vector<MeetingPair> met;
  for (const unsigned threads : {1U, 2U, 5U}) {
    PairSearch search(primitives, {.threads = threads});
    const PairLists found = found_by(search, surfaces.positions(), end.positions(), 1e-3);
    std::vector<NearPair> near_now;
    find_near(primitives, found, surfaces.positions(), 5e-4, near_now, threads);
    std::vector<MeetingPair> met_now;
    find_meetings(primitives, found, surfaces.positions(), end.positions(), met_now, threads);
    if (threads == 1) {
      pairs = found;
      near = near_now;
      met = met_now;
      CHECK(near.size() > 1000);
      CHECK(met.size() > 100);
      continue;
    }
    CHECK(found.of_kind == pairs.of_kind);
    REQUIRE(near_now.size() == near.size());
    for (std::size_t i = 0; i < near.size(); ++i) {
      CHECK(near_now[i].pair == near[i].pair);
      CHECK(near_now[i].gap == near[i].gap);
      CHECK(near_now[i].separation.weights == near[i].separation.weights);
      CHECK(near_now[i].separation.direction == near[i].separation.direction);
    }
    REQUIRE(met_now.size() == met.size());
    for (std::size_t i = 0; i < met.size(); ++i) {
      CHECK(met_now[i].pair == met[i].pair);
      CHECK(met_now[i].meeting.time == met[i].meeting.time);
    }
  }
}

TEST_CASE("parts of the leaves, in any order, visit the pairs that all of them visit") {
  Surfaces surfaces;
  add_folded_sheet(surfaces, 30, 0.01, 6, 1e-3, Vector3::Zero(), 5e-4, 0);
  const Primitives primitives(surfaces.lists({{0, 0}}));
  std::vector<Box> boxes, balls;
  for (const Edge& edge : primitives.edges()) {
    boxes.push_back(Box::empty());
    for (const NodeIndex node : edge.nodes) boxes.back().include(surfaces.positions()[node]);
  }
  for (const Ball& ball : primitives.balls()) {
    balls.push_back(Box::empty());
    balls.back().include(surfaces.positions()[ball.node]);
  }
  BoxTree edges, nodes;
  edges.build(boxes, std::vector<Group>(boxes.size(), 0));
  nodes.build(balls, std::vector<Group>(balls.size(), 0));
  const auto visited = [&](std::size_t parts) {
    std::vector<Pair> found;
    Effort effort(Effort::of_search(primitives));
    const auto any = [](Group) { return ~std::uint32_t{0}; };
    const auto visit = [&](std::uint32_t a, std::uint32_t b) { found.push_back({a, b}); };
    for (std::size_t part = parts; part-- > 0;) {
      const auto bound = [&](const BoxTree& tree, std::size_t at) { return tree.leaves() * at / parts; };
      edges.for_own_overlaps(bound(edges, part), bound(edges, part + 1), any, effort, visit);
      BoxTree::for_overlaps(nodes, bound(nodes, part), bound(nodes, part + 1), edges, any, effort, visit);
    }
    std::sort(found.begin(), found.end());
    return found;
  };
  const auto all = visited(1);
  CHECK(all.size() > boxes.size());
  CHECK(visited(2) == all);
  CHECK(visited(7) == all);
}

TEST_CASE("one great triangle, far nodes and a great common offset change no pairs") {
  Surfaces surfaces;
  add_folded_sheet(surfaces, 60, 0.01, 10, 5e-4, Vector3::Zero(), 5e-4, 0);
  const auto search_in = [](const Surfaces& net, PairLists& found) {
    const Primitives primitives(net.lists({{0, 0}}));
    PairSearch search(primitives);
    search.find(net.positions(), 1e-3, found);
  };
  PairLists alone, with_others;
  search_in(surfaces, alone);
  Surfaces larger = surfaces;
  const NodeIndex a = larger.add({-100, -100, -1}), b = larger.add({100, -100, -1}), c = larger.add({0, 1e9, -1});
  larger.triangles.push_back({{a, b, c}, 5e-4, 0});
  search_in(larger, with_others);
  CHECK(alone.size() > 1000);
  CHECK(with_others.of_kind == alone.of_kind);
}

TEST_CASE("positions that have collapsed end with an error, within bounded time and memory") {
  Surfaces surfaces;
  add_folded_sheet(surfaces, 80, 0.01, 10, 3e-3, Vector3::Zero(), 5e-4, 0);
  for (auto& component : surfaces.x) std::fill(component.begin(), component.end(), 0.5);
  PrimitiveLists lists = surfaces.lists({{0, 0, true}});
  const Primitives primitives(lists);
  PairSearch search(primitives, {.pairs_for_each = 4, .always = 1000});
  PairLists found;
  CHECK_THROWS_WITH_AS(search.find(surfaces.positions(), 1e-3, found), doctest::Contains("more than"), Error);
  PairSearch in_threads(primitives, {.pairs_for_each = 4, .always = 1000, .threads = 3});
  CHECK_THROWS_WITH_AS(in_threads.find(surfaces.positions(), 1e-3, found), doctest::Contains("more than"), Error);
  CHECK(found.size() <= 4 * (primitives.balls().size() + primitives.edges().size() + primitives.triangles().size()));
  // Of groups that are not checked, in the same place: nothing is compared.
  for (std::size_t i = 0; i < lists.balls.size(); ++i) lists.balls[i].group = i % 2 == 0 ? 1 : 2;
  lists.checked = {{1, 3, true, true, true}, {2, 3, true, true, true}};
  const Primitives apart(lists);
  PairSearch none(apart);
  CHECK_NOTHROW(none.find(surfaces.positions(), 1e-3, found));
  CHECK(found.size() == 0);
}

TEST_CASE("long needles whose boxes all overlap end with an error, not after hours") {
  // 12,000 edges side by side along the diagonal of a cube, none near another.
  Surfaces surfaces;
  PrimitiveLists lists;
  PairDice dice(13);
  for (int i = 0; i < 12000; ++i) {
    const Vector3 shift = dice.vector(0.3);
    const NodeIndex a = surfaces.add(Vector3::Constant(-1.0) + shift), b = surfaces.add(Vector3::Constant(1.0) + shift);
    lists.edges.push_back({{a, b}, 0.0, 0});
  }
  lists.checked = {{0, 0}};
  const Primitives primitives(lists);
  PairSearch search(primitives);
  PairLists found;
  CHECK_THROWS_WITH_AS(search.find(surfaces.positions(), 1e-6, found), doctest::Contains("overlap"), Error);
}

TEST_CASE("coordinates that are not finite are refused with the node's number") {
  Surfaces surfaces;
  add_folded_sheet(surfaces, 10, 0.01, 3, 3e-3, Vector3::Zero(), 5e-4, 0);
  const Primitives primitives(surfaces.lists({{0, 0}}));
  PairSearch search(primitives);
  PairLists found;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200}) {
    Surfaces broken = surfaces;
    broken.x[1][17] = bad;
    CHECK_THROWS_WITH_AS(search.find(broken.positions(), 1e-3, found), doctest::Contains("node 17"), Error);
    CHECK_THROWS_AS(search.find(surfaces.positions(), broken.positions(), 1e-3, found), Error);
  }
  Positions few = surfaces.positions();
  few.nodes = 50;
  CHECK_THROWS_WITH_AS(search.find(few, 1e-3, found), doctest::Contains("50 nodes"), Error);
  const Primitives nothing{PrimitiveLists{}};
  PairSearch empty(nothing);
  CHECK_NOTHROW(empty.find({{nullptr, nullptr, nullptr}, 0}, 1e-3, found));
  CHECK(found.size() == 0);
}
