// Viscosity functions against their formulas and differences.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "shipped.hpp"

using namespace springnet::test;

namespace {
double power(double rate, double damping, double exponent, double linear_below = 1e-6) {
  return force(viscosity("power"), {1.0, rate, 1.0, {damping, exponent, linear_below}});
}
}  // namespace

TEST_CASE("viscosity functions, by their formulas") {
  CHECK(force(viscosity("linear"), {1.0, 0.5, 1.0, {3.0}}) == 1.5);
  CHECK(force(viscosity("linear"), {1.0, -0.5, 1.0, {3.0}}) == -1.5);
  CHECK(force(viscosity("relative"), {0.5, 0.0, 1.0, {3.0}}) == 1.5);
  CHECK(power(0.5, 3.0, 2.0) == 0.75);
  CHECK(power(-0.5, 3.0, 2.0) == -0.75);
  CHECK(power(-0.5, 3.0, 1.0) == -1.5);
  CHECK(relative(power(4.0, 3.0, 0.5), 6.0) < 1e-15);     // rounding
  CHECK(relative(power(-4.0, 3.0, 1.5), -24.0) < 1e-15);  // rounding
}

TEST_CASE("a viscosity function dissipates energy in both directions") {
  for (const double exponent : {0.3, 0.5, 1.0, 1.5, 2.0, 5.0}) {
    for (const double rate : {-10.0, -1e-3, -1e-9, 1e-9, 1e-3, 10.0}) {
      CAPTURE(exponent);
      CAPTURE(rate);
      CHECK(power(rate, 2.0, exponent) * rate > 0.0);
      CHECK(power(-rate, 2.0, exponent) == -power(rate, 2.0, exponent));
    }
  }
}

TEST_CASE("derivatives of viscosity functions") {
  const double h = 1e-3;
  for (const double rate : {-2.0, -0.3, 0.3, 1.0, 2.0}) {
    CAPTURE(rate);
    const LawAnswer linear = evaluate(viscosity("linear"), Sample{1.0, rate, 1.0, {3.0}});
    CHECK(linear.by_q[0] == 0.0);
    CHECK(linear.by_rate[0] == 3.0);
    CHECK(linear.by_parameters[0][0] == rate);
    const LawAnswer relative_speed = evaluate(viscosity("relative"), Sample{std::abs(rate), 0.0, 1.0, {3.0}});
    CHECK(relative_speed.by_q[0] == 3.0);
    CHECK(relative_speed.by_parameters[0][0] == std::abs(rate));
    for (const double exponent : {0.4, 1.0, 1.5, 3.0}) {
      CAPTURE(exponent);
      // Away from the seam at linear_below the power is smooth. Rounding 2e-16 Q / h; Q < 24 N here.
      const LawAnswer answer = evaluate(viscosity("power"), Sample{1.0, rate, 1.0, {3.0, exponent, 1e-6}});
      const auto by_rate = derivative([&](double u) { return power(u, 3.0, exponent); }, rate, h);
      CHECK(std::abs(answer.by_rate[0] - by_rate) < 1e-10);
      CHECK(answer.by_q[0] == 0.0);
      const auto by_damping = derivative([&](double d) { return power(rate, d, exponent); }, 3.0, h);
      CHECK(std::abs(answer.by_parameters[0][0] - by_damping) < 1e-10);
      if (exponent == 1.0) continue;  // below 1 the formula has its linear part, so it is not smooth across 1
      const auto by_exponent = derivative([&](double n) { return power(rate, 3.0, n); }, exponent, h);
      CHECK(std::abs(answer.by_parameters[1][0] - by_exponent) < 1e-10);
      CHECK(answer.by_parameters[2][0] == 0.0);
    }
  }
}

TEST_CASE("power: force and every derivative are finite at rest") {
  const double linear_below = 1e-3;
  for (const double exponent : {0.3, 0.5, 1.0, 1.2, 1.5, 2.0, 7.0}) {
    for (const double rate : {0.0, -0.0, 1e-300, -1e-300, std::numeric_limits<double>::denorm_min()}) {
      CAPTURE(exponent);
      CAPTURE(rate);
      const LawAnswer at = evaluate(viscosity("power"), Sample{1.0, rate, 1.0, {3.0, exponent, linear_below}});
      // Zero to far below anything that matters: (1e-300)^0.3 is what the slope at rest has bounded.
      CHECK(std::abs(at.force[0]) < 1e-290);
      CHECK(std::isfinite(at.by_rate[0]));
      CHECK(at.by_rate[0] >= 0.0);
      for (const Array& each : at.by_parameters) CHECK(std::isfinite(each[0]));
    }
    const double slope = evaluate(viscosity("power"), Sample{1.0, 0.0, 1.0, {3.0, exponent, linear_below}}).by_rate[0];
    if (exponent < 1.0) CHECK(relative(slope, 3.0 * std::pow(linear_below, exponent - 1.0)) < 1e-15);
    if (exponent == 1.0) CHECK(slope == 3.0);
    // Above 1 it is 0, of which (2e-308)^(n - 1) is left.
    if (exponent > 1.0) CHECK(slope < 1e-60);
  }
}

TEST_CASE("power with an exponent below 1: linear below its rate, without a jump") {
  const double seam = 1e-2;
  CHECK(relative(power(seam / 2.0, 3.0, 0.5, seam), power(seam, 3.0, 0.5, seam) / 2.0, 0.0) < 1e-15);
  // Across one rounding step of the rate the force moves by rounding.
  CHECK(relative(power(std::nextafter(seam, 0.0), 3.0, 0.5, seam), power(seam, 3.0, 0.5, seam), 0.0) < 1e-15);
  CHECK(power(4.0, 3.0, 0.5, seam) == power(4.0, 3.0, 0.5, 1e-6));
}

TEST_CASE("viscosity functions return nan for nan") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(std::isnan(force(viscosity("linear"), {1.0, nan, 1.0, {3.0}})));
  CHECK(std::isnan(force(viscosity("relative"), {nan, 0.0, 1.0, {3.0}})));
  CHECK(std::isnan(power(nan, 3.0, 2.0)));
  CHECK(std::isnan(power(nan, 3.0, 0.5)));
}
