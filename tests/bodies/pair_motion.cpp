// Where the closest points of a pair are, how fast they separate, and how that changes, against differences.

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "bodies.hpp"
#include "constraints/pair_motion.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("rates of a pair's gap are the derivatives of the gap along straight paths") {
  // Two triangles, whose corners and edges meet, and two balls.
  Network net;
  for (int i = 0; i < 2; ++i) {
    net.begin_body("triangle " + std::to_string(i));
    const auto first = static_cast<NodeIndex>(net.nodes().size());
    for (int k = 0; k < 3; ++k) net.add_node(point({0.3 * k + i, 0.2 * k * k, 0.7 * i}, 1.0));
    net.add_face({first, first + 1, first + 2});
    net.end_body();
    net.set_extent(net.bodies().size() - 1, 0.01, 0.0);
  }
  add_ball(net, "ball", {5, 0, 0}, at_rest, 1.0, 0.1);
  add_ball(net, "other", {6, 0, 0}, at_rest, 1.0, 0.2);
  touch_all(net, frictionless);
  std::vector<std::uint32_t> numbers(8);
  std::iota(numbers.begin(), numbers.end(), 0u);
  const BodyContacts bodies(net, numbers, numbers);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  std::array<int, 3> seen{};  // of each kind
  for (int trial = 0; trial < 400; ++trial) {
    std::array<std::vector<double>, 3> x, v;
    for (std::size_t c = 0; c < 3; ++c)
      for (int k = 0; k < 8; ++k) {
        x[c].push_back(coordinate(random));
        v[c].push_back(coordinate(random));
      }
    const auto at = [&](double time, proximity::PairKind kind, proximity::Pair pair) {
      std::array<std::vector<double>, 3> moved = x;
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < 8; ++k) moved[c][k] += time * v[c][k];
      return pair_motion(bodies, kind, pair, {moved[0].data(), moved[1].data(), moved[2].data()},
                         {v[0].data(), v[1].data(), v[2].data()}, 8);
    };
    const proximity::Primitives& all = bodies.primitives();
    const auto check = [&](proximity::PairKind kind, proximity::Pair pair) {
      if (!all.may_touch(kind, pair)) return;
      constexpr double h = 1e-5;
      const PairMotion now = at(0.0, kind, pair), before = at(-h, kind, pair), after = at(h, kind, pair);
      // Where closest points pass from a face to an edge or a corner the second derivative jumps, and where bodies come
      // near each other it is great.
      if (now.gap < 0.05) return;
      for (std::size_t i = 0; i < 4; ++i)
        if ((before.weights[i] != 0.0) != (after.weights[i] != 0.0)) return;
      ++seen[static_cast<std::size_t>(kind)];
      const auto rate = [](const PairMotion& motion) { return motion.normal.dot(motion.velocity); };
      CAPTURE(trial);
      CAPTURE(static_cast<int>(kind));
      // Central differences: h^2 times third derivatives, some 1e3 / s^3, and rounding 1e-16 / h.
      CHECK(rate(now) == doctest::Approx((after.gap - before.gap) / (2.0 * h)).epsilon(1e-6));
      CHECK(now.bias == doctest::Approx((rate(after) - rate(before)) / (2.0 * h)).epsilon(1e-4));
    };
    for (std::uint32_t i = 0; i < all.balls().size(); ++i) {
      for (std::uint32_t j = i + 1; j < all.balls().size(); ++j) check(proximity::PairKind::node_node, {i, j});
      for (std::uint32_t j = 0; j < all.triangles().size(); ++j) check(proximity::PairKind::node_triangle, {i, j});
    }
    for (std::uint32_t i = 0; i < all.edges().size(); ++i)
      for (std::uint32_t j = i + 1; j < all.edges().size(); ++j) check(proximity::PairKind::edge_edge, {i, j});
  }
  for (const int count : seen) CHECK(count >= 100);
}
