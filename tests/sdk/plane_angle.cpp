// The branch-free angle of a vector against the C library's in extended precision.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include <springnet/sdk/math.hpp>

using springnet::sdk::plane_angle;

namespace {

// In units of the last place of the exact result, whose own error is 2^-11 of that.
double error(double y, double x) {
  const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
  const double size = std::abs(static_cast<double>(exact));
  const double unit = std::nextafter(size, std::numeric_limits<double>::infinity()) - size;
  return static_cast<double>(std::abs(static_cast<long double>(plane_angle(y, x)) - exact)) / unit;
}

}  // namespace

TEST_CASE("a plane angle is within two units in the last place, in all quadrants and octants") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> side(-1.0, 1.0), exponent(-30.0, 30.0);
  double worst = 0.0;
  for (int i = 0; i < 300000; ++i) {
    const double x = side(random), y = side(random);
    worst = std::max({worst, error(y, x), error(y, x * std::exp2(exponent(random)))});
  }
  // Around the axes, the diagonals and the bounds between the parts of an octant.
  for (const double tangent : {0.0, 0x1p-60, 0x1p-27, 0.25, 0.5, 1.0, 2.0}) {
    double above = tangent, below = tangent;
    for (int i = 0; i < 200; ++i) {
      for (const double t : {above, below})
        for (const double x : {1.0, -1.0}) worst = std::max({worst, error(t, x), error(-t, x), error(x, t)});
      above = std::nextafter(above, 4.0);
      below = std::nextafter(below, -4.0);
    }
  }
  CHECK(worst <= 2.0);
  CHECK(worst > 0.5);  // it is compared with something exact
}

TEST_CASE("plane angles of axes, of zeros, of what is not finite") {
  constexpr double pi = std::numbers::pi, infinity = std::numeric_limits<double>::infinity();
  const auto same = [](double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  };
  CHECK(same(plane_angle(0.0, 1.0), 0.0));
  CHECK(same(plane_angle(-0.0, 1.0), -0.0));
  CHECK(same(plane_angle(0.0, -1.0), pi));
  CHECK(same(plane_angle(-0.0, -1.0), -pi));
  for (const double y : {3.0, infinity, 1e-300}) {
    CHECK(same(plane_angle(y, 0.0), pi / 2));
    CHECK(same(plane_angle(-y, -0.0), -pi / 2));
  }
  CHECK(same(plane_angle(2.0, 2.0), pi / 4));
  CHECK(same(plane_angle(-2.0, -2.0), -3 * pi / 4));
  for (const double y : {0.0, -0.0})
    for (const double x : {0.0, -0.0}) CHECK(same(plane_angle(y, x), y));
  CHECK(plane_angle(1.0, infinity) == 0.0);
  CHECK(plane_angle(1.0, -infinity) == pi);
  CHECK(plane_angle(-infinity, 1e300) == -pi / 2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(std::isnan(plane_angle(nan, 1.0)));
  CHECK(std::isnan(plane_angle(1.0, nan)));
  CHECK(std::isnan(plane_angle(0.0, nan)));
  CHECK(std::isnan(plane_angle(infinity, -infinity)));
}
