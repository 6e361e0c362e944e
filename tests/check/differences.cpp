// Differences against known slopes: their estimate of the error must hold.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "check/differences.hpp"

using namespace springnet::check;

namespace {

template <class Function>
Slope slope_of(const Function& f, double x, double step) {
  const Functions functions = [&](const std::vector<double>& xs) {
    std::vector<std::vector<double>> values(1);
    for (const double each : xs) values[0].push_back(f(each));
    return values;
  };
  return slopes(functions, x, step)[0];
}

}  // namespace

TEST_CASE("slopes of smooth functions are within the error that they tell") {
  const auto check = [](const Slope& slope, double exact, double accuracy) {
    CHECK(std::abs(slope.value - exact) <= 10.0 * slope.error);
    CHECK(slope.error <= accuracy * std::abs(exact));
    CHECK(slope.smooth());
  };
  check(slope_of([](double x) { return std::exp(3.0 * x); }, 1.2, 0.12), 3.0 * std::exp(3.6), 1e-10);
  check(slope_of([](double x) { return std::sqrt(x); }, 0.01, 0.001), 5.0, 1e-10);
  check(slope_of([](double x) { return 1e6 + std::sin(x); }, 0.5, 0.05), std::cos(0.5), 1e-6);  // digits are lost
}

TEST_CASE("a kink and a jump are no smooth place") {
  const Slope kink = slope_of([](double x) { return std::abs(x - 1.0); }, 1.0, 0.1);
  CHECK_FALSE(kink.smooth());
  CHECK(kink.left == doctest::Approx(-1.0));
  CHECK(kink.right == doctest::Approx(1.0));
  CHECK_FALSE(slope_of([](double x) { return x < 1.0 ? 0.0 : 1.0; }, 1.0, 0.1).smooth());
}

TEST_CASE("a function that is not finite nearby has no estimate") {
  CHECK_FALSE(std::isfinite(slope_of([](double x) { return x > 1.0 ? NAN : x; }, 1.0, 0.1).error));
}
