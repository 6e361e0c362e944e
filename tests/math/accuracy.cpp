// Every function of sdk/math.hpp against MPFR, on random arguments and around the places where a method changes.
#include <cmath>
#include <initializer_list>

#include <doctest/doctest.h>

#include <springnet/sdk/math.hpp>

#include "functions.hpp"

using namespace springnet::test;

TEST_CASE("functions are within their bounds on random arguments") {
  for (const Function& function : functions()) {
    const Worst worst = worst_error(function, 100000, 1);
    CAPTURE(function.name);
    CAPTURE(worst.x);
    CAPTURE(worst.y);
    CHECK(worst.error <= function.bound);
    CHECK(worst.error > 0.49);  // it is compared with something exact
  }
}

TEST_CASE("functions are within their bounds at powers of two, multiples of pi/4 and where formulas change") {
  for (const Function& function : functions()) {
    if (!function.ranges_2.empty()) continue;
    CAPTURE(function.name);
    const auto around = [&function](double x) {
      double above = x, below = x;
      for (int i = 0; i < 20; ++i) {
        for (const double at : {above, below, -above, -below}) {
          CAPTURE(at);
          CHECK(error_at(function, at, 0.0) <= function.bound);
        }
        above = std::nextafter(above, HUGE_VAL);
        below = std::nextafter(below, 0.0);
      }
    };
    for (int exponent = -1074; exponent<1024; exponent += exponent> - 70 && exponent < 70 ? 1 : 37)
      around(std::ldexp(1.0, exponent));
    for (int k = 1; k < 100; ++k) around(k * 0x1.921fb54442d18p-1);
    for (const double x : {0.3466,
                           0.55,
                           1.5,
                           6.0,
                           37.0,
                           20.0,
                           22.0,
                           40.0,
                           60.0,
                           708.4,
                           709.78271289338397,
                           710.0,
                           710.4758600739439,
                           711.0,
                           745.13321910194,
                           746.0,
                           0x1p23,
                           0x1p52,
                           0x1p53,
                           0x1.921fb54442d18p+22,
                           0x1.6ac5b262ca1ffp849,
                           1e22,
                           1e300})
      around(x);
    // The doubles closest to a multiple of pi/2.
    around(6381956970095103.0 * 0x1p797);
    around(5.31937264832654141671e+255);
  }
}

TEST_CASE("powers are exact where they are doubles, and near the bounds of their range") {
  for (const Function& function : functions()) {
    if (function.name != "pow") continue;
    for (int base = 1; base < 200; ++base) {
      for (int exponent = -3; exponent < 8; ++exponent) {
        CAPTURE(base);
        CAPTURE(exponent);
        CHECK(error_at(function, base, exponent) <= function.bound);
        CHECK(error_at(function, 1.0 / base, 0.5 * exponent) <= function.bound);
        CHECK(error_at(function, -base, exponent) <= function.bound);
      }
    }
    for (double x = 1.5; x < 1e300; x *= 7.3) {
      for (const double result : {1023.9, 1024.0, 1024.1, -1021.9, -1022.1, -1050.3, -1073.0, -1074.3, -1075.2}) {
        CAPTURE(x);
        CAPTURE(result);
        CHECK(error_at(function, x, result / std::log2(x)) <= function.bound);
      }
    }
  }
}

TEST_CASE("quick powers have the error that is documented, and are 0 or infinite where they would not be normal") {
  using springnet::sdk::quick_pow;
  for (double x = 0x1p-1022; x < 1e308; x *= 3.7) {
    for (const double y : {-7.3, -1.0, -0.4, 0.0, 0.3, 1.0, 1.7, 2.0, 9.0}) {
      CAPTURE(x);
      CAPTURE(y);
      const double power = y * std::log2(x), exact = springnet::sdk::pow(x, y);
      if (power > 1024.0) {
        CHECK(quick_pow(x, y) == HUGE_VAL);
      } else if (power < -1023.0) {
        CHECK(quick_pow(x, y) == 0.0);
      } else if (power > -1021.0 && power < 1023.0) {
        CHECK(std::abs(quick_pow(x, y) - exact) <= 0x1p-51 * (1.0 + std::abs(power)) * exact);
      }
    }
  }
}
