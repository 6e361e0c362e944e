// Crossings, exactly: whole numbers, numbers that rounding cannot tell, and bodies that were pushed into each other.
#include "proximity/crossings.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "proximity/orientation.hpp"
#include "random_pairs.hpp"
#include "surfaces.hpp"

using namespace springnet;
using namespace springnet::proximity;

TEST_CASE("orientations of whole numbers are those of integers") {
  PairDice dice(31);
  int in_plane = 0;
  for (int round = 0; round < 50000; ++round) {
    const int size = round % 2 == 0 ? 2 : 100000;
    std::array<std::array<std::int64_t, 3>, 4> x;
    Corners real;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        x[i][k] = dice.whole(-size, size);
        real[i][static_cast<Eigen::Index>(k)] = static_cast<double>(x[i][k]);
      }
    std::array<std::array<std::int64_t, 3>, 3> e;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) e[i][k] = x[i + 1][k] - x[0][k];
    const std::int64_t volume = e[2][0] * (e[0][1] * e[1][2] - e[0][2] * e[1][1]) +
                                e[2][1] * (e[0][2] * e[1][0] - e[0][0] * e[1][2]) +
                                e[2][2] * (e[0][0] * e[1][1] - e[0][1] * e[1][0]);
    CHECK(orientation(real[0], real[1], real[2], real[3]) == (volume > 0) - (volume < 0));
    in_plane += volume == 0;
  }
  CHECK(in_plane > 1000);
}

TEST_CASE("orientations of points that are nearly on a line are exact") {
  // a, a + u, a + u + e, a + u + f with a long u and short e and f: the volume is (e x f) . u, in integers, where
  // rounded products of u with itself leave 2^-53 of its cube.
  PairDice dice(32);
  int in_plane = 0;
  for (int round = 0; round < 20000; ++round) {
    const Vector3 a = dice.grid_vector(1 << 20), u = 1048576.0 * dice.grid_vector(1 << 20) + dice.grid_vector(1 << 20),
                  e = dice.grid_vector(3), f = dice.grid_vector(3);
    const Vector3 across = e.cross(f);  // exact, and so are its products with u: below 2^53 in all
    std::int64_t volume = 0;
    for (Eigen::Index k = 0; k < 3; ++k)
      volume += static_cast<std::int64_t>(across[k]) * static_cast<std::int64_t>(u[k]);
    CHECK(orientation(a, a + u, a + u + e, a + u + f) == (volume > 0) - (volume < 0));
    in_plane += volume == 0;
  }
  CHECK(in_plane > 100);
}

TEST_CASE("orientations are exact where rounding hides them") {
  // Points near the plane x + y + z = 1, one unit in the last place to either side.
  const Vector3 a(1, 0, 0), b(0, 1, 0), c(0, 0, 1);
  const double third = 0.25;
  const Vector3 d(third, third, 0.5);
  CHECK(orientation(a, b, c, d) == 0);
  CHECK(orientation(a, b, c, {third, third, std::nextafter(0.5, 1.0)}) == 1);
  CHECK(orientation(a, b, c, {third, third, std::nextafter(0.5, 0.0)}) == -1);
  // And far away: coordinates of 1e9 whose differences are small.
  const Vector3 far = Vector3(0x1p30, -0x1p30, 0x1p30);
  CHECK(orientation(far + a, far + b, far + c, far + d) == 0);
  const Vector3 above = far + d + Vector3(0, 0, 0x1p-22);
  CHECK(orientation(far + a, far + b, far + c, above) == 1);
  // Products that vanish.
  CHECK(orientation(1e-120 * a, 1e-120 * b, 1e-120 * c, Vector3::Zero()) == -1);
  CHECK(orientation(1e149 * a, 1e149 * b, 1e149 * c, Vector3::Zero()) == -1);
}

TEST_CASE("an edge crosses a triangle with its ends on both sides, also through the border") {
  const Vector3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  const auto through = [&](double x, double y, double below, double above) {
    return crosses({x, y, below}, {x, y, above}, a, b, c);
  };
  CHECK(through(1, 1, -1, 1));
  CHECK(through(1, 1, 1, -1));
  CHECK(through(2, 0, -1, 1));  // border
  CHECK(through(0, 0, -1, 1));  // corner
  CHECK(!through(1, 1, 0, 1));  // touches
  CHECK(!through(1, 1, 1, 2));
  CHECK(!through(3, 3, -1, 1));
  CHECK(!through(-1e-300, 1, -1, 1));
  CHECK(!crosses({-1, 1, 0}, {5, 1, 0}, a, b, c));  // in the plane
}

TEST_CASE("bodies that only touch do not cross, and those pushed into each other do") {
  Surfaces surfaces;
  add_block(surfaces, 4, 0.1, Vector3::Zero(), 0.0, 0);
  add_block(surfaces, 4, 0.1, Vector3(0.03, 0.02, 0.4), 0.0, 1);
  const Primitives primitives(surfaces.lists({{0, 1}, {1, 1}}));
  CHECK(find_crossings(primitives, surfaces.positions()).empty());
  for (NodeIndex node = 64; node < 128; ++node) surfaces.set(node, surfaces.positions()[node] - Vector3(0, 0, 0.15));
  const auto crossings = find_crossings(primitives, surfaces.positions());
  CHECK(!crossings.empty());
  for (std::size_t i = 0; i + 1 < crossings.size(); ++i) CHECK(crossings[i] < crossings[i + 1]);
  // Each by itself, for all pairs.
  std::size_t expected = 0;
  const Positions x = surfaces.positions();
  for (const Edge& edge : primitives.edges())
    for (const Triangle& triangle : primitives.triangles())
      if (edge.group != triangle.group)
        expected += crosses(x[edge.nodes[0]], x[edge.nodes[1]], x[triangle.nodes[0]], x[triangle.nodes[1]],
                            x[triangle.nodes[2]]);
  CHECK(crossings.size() == expected);
}
