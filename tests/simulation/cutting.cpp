// Which springs a polygon cuts.

#include "simulation/cutting.hpp"

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("a segment is cut where it passes through the polygon, not beside it") {
  const CuttingPolygon square({{0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}});
  CHECK(square.crosses({1, 1, 0}, {1, 1, 2}));
  CHECK(square.crosses({1, 1, 2}, {1, 1, 0}));
  CHECK(square.crosses({-1, 1, 0}, {3, 1, 2}));  // through (1, 1, 1)
  CHECK_FALSE(square.crosses({3, 1, 0}, {3, 1, 2}));
  CHECK_FALSE(square.crosses({1, 1, 0}, {1, 1, 0.9}));
  CHECK_FALSE(square.crosses({0.5, 0.5, 1}, {1.5, 0.5, 1}));  // in the plane
}

TEST_CASE("a polygon that is not convex, in an inclined plane") {
  // An L in the plane x = y, seen along x.
  const CuttingPolygon el({{0, 0, 0}, {2, 2, 0}, {2, 2, 1}, {1, 1, 1}, {1, 1, 2}, {0, 0, 2}});
  const Vector3 across(1, -1, 0);
  const auto hit = [&](double s, double z) {
    const Vector3 middle(s, s, z);
    return el.crosses(middle - across, middle + across);
  };
  CHECK(hit(0.5, 0.5));
  CHECK(hit(1.5, 0.5));
  CHECK(hit(0.5, 1.5));
  CHECK_FALSE(hit(1.5, 1.5));  // in the notch
  CHECK_FALSE(hit(2.5, 0.5));
}

TEST_CASE("polygons without area, or not planar, are refused") {
  CHECK_THROWS_AS(CuttingPolygon({{0, 0, 0}, {1, 0, 0}}), Error);
  CHECK_THROWS_AS(CuttingPolygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}), Error);
  CHECK_THROWS_WITH_AS(CuttingPolygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0.5}, {0, 1, 0}}),
                       doctest::Contains("outside the plane"), Error);
}
