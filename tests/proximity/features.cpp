// Corners, edges and faces between which pairs are closest, and the primitives that share them.
#include "proximity/shared_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>

#include "proximity/distance.hpp"
#include "random_pairs.hpp"

using namespace springnet;
using namespace springnet::proximity;

TEST_CASE("between the features that are closest the distance is that of the pair") {
  PairDice dice(11);
  for (int i = 0; i < 30'000; ++i)
    for (const PairKind kind : pair_kinds) {
      const Corners x = dice.corners(i % 2 == 0 ? 0 : 5);
      const Separation at = separation(kind, x);
      const Separation between = separation_between(kind, x, features_of(kind, at.weights));
      const double size = i % 2 == 0 ? 1.0 : 1e4;  // m, of coordinates, whose rounding it has
      if (are_nearly_parallel(kind, x) || at.distance < 1e-2) continue;
      REQUIRE(std::abs(between.distance - at.distance) <= 1e-12 * size);
      REQUIRE((between.direction - at.direction).norm() <= 1e-9 * size);
    }
}

TEST_CASE("features go on beyond their borders: the gradient is the weights along the direction") {
  PairDice dice(12);
  int checked = 0, beyond = 0;
  for (int i = 0; i < 3000; ++i)
    for (const auto& [kind, features] :
         {std::tuple(PairKind::node_triangle, 0b1111u), std::tuple(PairKind::node_triangle, 0b1011u),
          std::tuple(PairKind::node_triangle, 0b0101u), std::tuple(PairKind::edge_edge, 0b1111u),
          std::tuple(PairKind::edge_edge, 0b1101u), std::tuple(PairKind::edge_edge, 0b0111u),
          std::tuple(PairKind::edge_edge, 0b1001u), std::tuple(PairKind::node_node, 0b0011u)}) {
      Corners x = dice.corners(0);
      const auto of = static_cast<Features>(features);
      const Separation at = separation_between(kind, x, of);
      double greatest = 0.0;
      for (const double weight : at.weights) greatest = std::max(greatest, std::abs(weight));
      // Far extrapolations amplify the errors of differences.
      if (at.distance < 0.1 || greatest > 5.0) continue;
      ++checked;
      for (int k = 0; k < count_of(kind); ++k) {
        const auto place = static_cast<std::size_t>(k);
        const double sign = k < first_nodes(kind) ? 1.0 : -1.0;
        if (sign * at.weights[place] < 0.0) ++beyond;
        if ((features >> k & 1u) == 0) REQUIRE(at.weights[place] == 0.0);
        for (Eigen::Index c = 0; c < 3; ++c) {
          constexpr double d = 1e-5;
          const double before = x[place][c];
          x[place][c] = before + d;
          const double more = separation_between(kind, x, of).distance;
          x[place][c] = before - d;
          const double less = separation_between(kind, x, of).distance;
          x[place][c] = before;
          // Differences of second order, with derivatives of third order of some 1e4.
          REQUIRE(std::abs((more - less) / (2.0 * d) - at.weights[place] * at.direction[c]) <= 1e-4);
        }
      }
    }
  CHECK(checked > 5000);
  CHECK(beyond > 2000);
}

TEST_CASE("the primitives that share features are those of a search through all") {
  std::mt19937 random(13);
  const auto whole = [&](unsigned below) { return static_cast<std::uint32_t>(random() % below); };
  constexpr unsigned nodes = 14;
  std::vector<Triangle> triangles;
  while (triangles.size() < 30) {
    const std::array<NodeIndex, 3> corners{whole(nodes), whole(nodes), whole(nodes)};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[0] == corners[2]) continue;
    triangles.push_back({corners, 0.1, whole(2)});
  }
  const Primitives all({corners_of(triangles), edges_of(triangles), triangles, {{0, 0, true}, {0, 1, true}}, {}});
  const SharedFeatures shared(all);
  const auto size_of = [&](PairKind kind, bool second) -> unsigned {
    if (kind == PairKind::edge_edge) return static_cast<unsigned>(all.edges().size());
    return static_cast<unsigned>(kind == PairKind::node_triangle && second ? all.triangles().size()
                                                                           : all.balls().size());
  };
  using Found = std::set<std::tuple<PairKind, std::uint32_t, std::uint32_t>>;
  const auto has = [&](PairKind kind, Pair pair, const std::vector<NodeIndex>& first,
                       const std::vector<NodeIndex>& second) {
    const std::array<NodeIndex, 4> of = all.nodes_of(kind, pair);
    const auto middle = of.begin() + first_nodes(kind), end = of.begin() + count_of(kind);
    const auto in = [](auto from, auto to, const std::vector<NodeIndex>& wanted) {
      return std::all_of(wanted.begin(), wanted.end(), [&](NodeIndex k) { return std::find(from, to, k) != to; });
    };
    return (in(of.begin(), middle, first) && in(middle, end, second)) ||
           (in(of.begin(), middle, second) && in(middle, end, first));
  };
  std::size_t most = 0;
  for (int i = 0; i < 400; ++i) {
    const PairKind kind = pair_kinds[whole(3)];
    Pair pair{whole(size_of(kind, false)), whole(size_of(kind, true))};
    if (kind != PairKind::node_triangle && pair.first > pair.second) std::swap(pair.first, pair.second);
    if ((kind != PairKind::node_triangle && pair.first == pair.second) || !all.may_touch(kind, pair)) continue;
    const auto features = static_cast<Features>(whole(16) & all_features(kind));
    std::vector<NodeIndex> first, second;
    for (int k = 0; k < count_of(kind); ++k)
      if ((features >> k & 1u) != 0)
        (k < first_nodes(kind) ? first : second).push_back(all.nodes_of(kind, pair)[static_cast<std::size_t>(k)]);
    Found found, expected;
    shared.for_each_pair_at(kind, pair, features, [&](PairKind of, Pair other) {
      CHECK(found.emplace(of, other.first, other.second).second);  // each once
    });
    if (!first.empty() && !second.empty())
      for (const PairKind of : pair_kinds)
        for (std::uint32_t a = 0; a < size_of(of, false); ++a)
          for (std::uint32_t b = 0; b < size_of(of, true); ++b)
            if ((of == PairKind::node_triangle || a < b) && all.may_touch(of, {a, b}) && has(of, {a, b}, first, second))
              expected.emplace(of, a, b);
    CHECK(found == expected);
    most = std::max(most, found.size());
  }
  CHECK(most >= 20);
}
