// Distances, proved for each pair: closest points bound the distance from above, and the plane perpendicular to the
// direction, which has one primitive on either side, from below.
#include "proximity/distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "random_pairs.hpp"

using namespace springnet;
using namespace springnet::proximity;

namespace {

Vector3 weighted(const Separation& found, const Corners& x) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < 4; ++i)
    if (found.weights[i] != 0.0) sum += found.weights[i] * (x[i] - x[0]);
  return sum;
}

// The least distance along the direction, of all nodes of both: less than the distance, by weak duality.
double between_planes(PairKind kind, const Vector3& direction, const Corners& x) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < first_nodes(kind); ++i)
    for (int j = first_nodes(kind); j < count_of(kind); ++j)
      least = std::min(least, direction.dot(x[static_cast<std::size_t>(i)] - x[static_cast<std::size_t>(j)]));
  return least;
}

void check_weights(PairKind kind, const Separation& found) {
  double first = 0.0, second = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double weight = found.weights[static_cast<std::size_t>(i)];
    const bool is_first = i < first_nodes(kind);
    CHECK((is_first ? weight : -weight) >= 0.0);
    (is_first ? first : second) += weight;
  }
  // sums of four numbers below 1
  CHECK(std::abs(first - 1.0) <= 4e-16);
  CHECK(std::abs(second + 1.0) <= 4e-16);
}

}  // namespace

TEST_CASE("the distance of a pair is that of its closest points and of the planes between it") {
  PairDice dice(1);
  int beyond = 0;
  for (int round = 0; round < 60000; ++round) {
    const PairKind kind = pair_kinds[static_cast<std::size_t>(round % 3)];
    const int shape = round / 3 % PairDice::shapes;
    const Corners x = dice.corners(shape);
    const Separation found = separation(kind, x);
    CAPTURE(round);
    check_weights(kind, found);
    CHECK(std::abs(found.direction.norm() - 1.0) <= 1e-15);
    // Coordinates below 4 (below 4e3 in shape 5): differences are rounded by 1e-15 (1e-12), sums of some of them too.
    const double rounding = shape == 5 ? 2e-12 : 4e-15;
    CHECK(std::abs(weighted(found, x).norm() - found.distance) <= rounding);
    CHECK(weighted(found, x).dot(found.direction) >= -rounding);
    // Slivers of 1e-7: the plane's direction is lost to 1e-16 / 1e-7, and the lever is 4.
    CHECK(between_planes(kind, found.direction, x) >= found.distance - (shape == 4 ? 1e-8 : 10.0 * rounding));
    // The quick test never says that a pair is beyond its distance, and often that it is beyond half of it.
    CHECK(!is_surely_beyond(kind, x, found.distance + rounding));
    beyond += is_surely_beyond(kind, x, 0.5 * found.distance);
  }
  CHECK(beyond > 30000);
}

TEST_CASE("distances of each region are those of the drawing") {
  const Vector3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  const auto check = [&](const Vector3& p, double distance, const Vector3& closest, const Vector3& direction) {
    const Separation found = separation(PairKind::node_triangle, {p, a, b, c});
    CHECK(found.distance == doctest::Approx(distance).epsilon(1e-15));  // short sums of small whole numbers
    CHECK((-(found.weights[1] * a + found.weights[2] * b + found.weights[3] * c) - closest).norm() <= 1e-15);
    CHECK((found.direction - direction).norm() <= 1e-15);
  };
  check({1, 1, 2}, 2.0, {1, 1, 0}, {0, 0, 1});
  check({1, 1, -3}, 3.0, {1, 1, 0}, {0, 0, -1});
  check({2, -3, 4}, 5.0, {2, 0, 0}, {0, -0.6, 0.8});
  check({-3, 2, 4}, 5.0, {0, 2, 0}, {-0.6, 0, 0.8});
  check({5, 5, 0}, 3.0 * std::sqrt(2.0), {2, 2, 0}, Vector3(1, 1, 0).normalized());
  check({-3, -4, 0}, 5.0, a, {-0.6, -0.8, 0});
  check({7, -1, 4}, std::sqrt(26.0), b, Vector3(3, -1, 4).normalized());
  check({0, 9, 12}, 13.0, c, Vector3(0, 5, 12).normalized());

  const auto edges = [](const Vector3& p, const Vector3& q, const Vector3& r, const Vector3& s) {
    return separation(PairKind::edge_edge, {p, q, r, s});
  };
  CHECK(edges({0, 0, 0}, {4, 0, 0}, {1, -1, 2}, {1, 3, 2}).distance == 2.0);             // crossing
  CHECK(edges({0, 0, 0}, {4, 0, 0}, {7, 4, 0}, {7, 9, 0}).distance == 5.0);              // ends
  CHECK(edges({0, 0, 0}, {4, 0, 0}, {2, 3, 0}, {2, 9, 0}).distance == 3.0);              // an end and an edge
  CHECK(edges({0, 0, 0}, {4, 0, 0}, {3, 0, 2}, {9, 0, 2}).distance == 2.0);              // parallel, side by side
  CHECK(edges({0, 0, 0}, {4, 0, 0}, {7, 4, 0}, {9, 4, 0}).distance == 5.0);              // parallel, apart
  CHECK(edges({0, 0, 0}, {4, 0, 0}, {6, 0, 0}, {9, 0, 0}).distance == 2.0);              // on one line
  CHECK(edges({1, 2, 2}, {1, 2, 2}, {-1, 0, 0}, {2, 0, 0}).distance == std::sqrt(8.0));  // one is a point
  CHECK(edges({1, 2, 2}, {1, 2, 2}, {1, 0, 2}, {1, 0, 2}).distance == 2.0);              // both are
}

// Edges above each other, one of which is longer by less than distances resolve, in any direction: the direction is
// perpendicular to both, so that the ends of neither are nearer than the distance says.
TEST_CASE("the direction between parallel edges is perpendicular to them, also beside their ends") {
  PairDice dice(9);
  double worst = 0.0;
  for (int trial = 0; trial < 2000; ++trial) {
    const double longer = std::array{1e-13, 2e-12, 1e-11, 1e-10}[static_cast<std::size_t>(trial % 4)];
    const Vector3 from = dice.vector(1.0), u = dice.vector(1.0).normalized(), up = 0.01 * u.unitOrthogonal();
    const std::array<Vector3, 4> x{from - longer * u, from + (0.1 + longer) * u, from + up, from + 0.1 * u + up};
    for (const std::array<Vector3, 4>& each : {x, std::array<Vector3, 4>{x[2], x[3], x[0], x[1]}}) {
      const Separation found = separation(PairKind::edge_edge, each);
      // The edges themselves are off by rounding of positions of order 1, of their length.
      worst = std::max(worst, std::abs(found.direction.dot(u)));
    }
  }
  CHECK(worst <= 1e-14);
}

TEST_CASE("weights and direction are the derivative of the distance") {
  PairDice dice(2);
  int checked = 0;
  for (int round = 0; round < 3000; ++round) {
    const PairKind kind = pair_kinds[static_cast<std::size_t>(round % 3)];
    const Corners x = dice.corners(0);
    const Separation found = separation(kind, x);
    if (found.distance < 0.05) continue;  // curvature 1 / distance, below
    ++checked;
    for (int i = 0; i < count_of(kind); ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(i);
        const double h = 1e-7;
        Corners after = x, before = x;
        after[k][axis] += h;
        before[k][axis] -= h;
        const double quotient = (separation(kind, after).distance - separation(kind, before).distance) / (2.0 * h);
        // The gradient changes by h times a curvature: of 1 / distance <= 20, times that of edges of about 1 m.
        CHECK(std::abs(quotient - found.weights[k] * found.direction[axis]) <= 2e-5);
      }
  }
  CHECK(checked > 2000);
}

TEST_CASE("pairs at distance 0 have a direction that depends on their corners alone") {
  const Vector3 o(1, 2, 3);
  CHECK(separation(PairKind::node_node, {o, o, o, o}).direction == Vector3(1, 0, 0));
  const Vector3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  const Vector3 in_face = separation(PairKind::node_triangle, {Vector3(1, 1, 0), a, b, c}).direction;
  CHECK(in_face.cwiseAbs() == Vector3(0, 0, 1));
  CHECK(separation(PairKind::node_triangle, {b, a, b, c}).direction.cwiseAbs() == Vector3(0, 0, 1));
  const Vector3 crossing = separation(PairKind::edge_edge, {a, b, Vector3(1, -1, 0), Vector3(1, 1, 0)}).direction;
  CHECK(crossing.cwiseAbs() == Vector3(0, 0, 1));
  const Vector3 on_line = separation(PairKind::edge_edge, {a, b, Vector3(2, 0, 0), Vector3(6, 0, 0)}).direction;
  CHECK(std::abs(on_line.x()) <= 1e-16);  // perpendicular to both
  CHECK(separation(PairKind::node_triangle, {o, o, o, o}).direction == Vector3(1, 0, 0));
  CHECK(separation(PairKind::edge_edge, {o, o, o, o}).distance == 0.0);
}

TEST_CASE("beyond the side on which it started a pair has a negative distance") {
  const Vector3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  const Vector3 side = separation(PairKind::node_triangle, {Vector3(1, 1, 0.5), a, b, c}).direction;
  const Separation before = on_side(separation(PairKind::node_triangle, {Vector3(1, 1, 0.1), a, b, c}), side);
  const Separation after = on_side(separation(PairKind::node_triangle, {Vector3(1, 1, -0.1), a, b, c}), side);
  CHECK(before.distance == 0.1);
  CHECK(after.distance == -0.1);
  CHECK(after.direction == before.direction);
}
