// Differences, integrals and poles of functions that are known.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "check/differences.hpp"
#include "check/pole.hpp"
#include "check/quadrature.hpp"

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

template <class Function, class Derivative>
Comparison comparison(const Function& f, const Derivative& derivative, double from, double to) {
  const Pairs pairs = [&](const std::vector<double>& xs) {
    std::vector<Pair> result(1);
    for (const double x : xs) {
      result[0].values.push_back(f(x));
      result[0].derivatives.push_back(derivative(x));
    }
    return result;
  };
  return compare_over(pairs, from, to)[0];
}

template <class Function>
std::optional<Pole> pole_of(const Function& f) {
  std::vector<double> grid, values;
  for (int k = 0; k <= 200; ++k) grid.push_back(0.01 * k);
  const Curve curve = [&](const std::vector<double>& xs) {
    std::vector<double> result;
    for (const double x : xs) result.push_back(f(x));
    return result;
  };
  return find_pole(curve, grid, curve(grid));
}

}  // namespace

TEST_CASE("slopes of smooth functions are within the error that they tell") {
  const auto check = [](const Slope& slope, double exact, double accuracy) {
    CHECK(std::abs(slope.value - exact) <= 10.0 * slope.error);
    CHECK(slope.error <= accuracy * std::abs(exact));
  };
  check(slope_of([](double x) { return std::exp(3.0 * x); }, 1.2, 0.12), 3.0 * std::exp(3.6), 1e-10);
  check(slope_of([](double x) { return std::sqrt(x); }, 0.01, 0.001), 5.0, 1e-10);
  check(slope_of([](double x) { return 1e6 + std::sin(x); }, 0.5, 0.05), std::cos(0.5), 1e-6);  // digits are lost
}

TEST_CASE("a function that is not finite nearby has no estimate") {
  CHECK_FALSE(std::isfinite(slope_of([](double x) { return x > 1.0 ? NAN : x; }, 1.0, 0.1).error));
  CHECK(comparison([](double x) { return x > 1.0 ? NAN : x; }, [](double) { return 1.0; }, 0.9, 1.1).verdict ==
        Verdict::undecided);
}

TEST_CASE("integrals show mistakes of a ten-thousandth of a millionth") {
  const auto exponential = [](double x) { return std::exp(40.0 * x); };
  const auto verdict = [&](double mistake) {
    return comparison(
               exponential, [&](double x) { return (1.0 + mistake) * 40.0 * std::exp(40.0 * x); }, 0.9, 1.1)
        .verdict;
  };
  CHECK(verdict(0.0) == Verdict::agrees);
  CHECK(verdict(1e-10) == Verdict::differs);
  CHECK(verdict(-1e-10) == Verdict::differs);
  // What rounding hides: digits are lost in the function itself.
  const auto lossy = [](double x) { return (1e8 + std::sin(x)) - 1e8; };
  const auto of_lossy = [&](double mistake) {
    return comparison(
               lossy, [&](double x) { return (1.0 + mistake) * std::cos(x); }, 0.4, 0.5)
        .verdict;
  };
  CHECK(of_lossy(0.0) != Verdict::differs);
  CHECK(of_lossy(1e-8) != Verdict::differs);
  CHECK(of_lossy(1e-3) == Verdict::differs);
}

TEST_CASE("a kink, a jump and a root are no mistakes, wherever they are") {
  for (int k = 1; k < 200; ++k) {
    const double at = 1.0 + 0.001 * k;
    CAPTURE(at);
    const auto kink =
        comparison([&](double x) { return std::abs(x - at); }, [&](double x) { return x < at ? -1.0 : 1.0; }, 1.0, 1.2);
    CHECK(kink.verdict != Verdict::differs);
    const auto jump = comparison([&](double x) { return x < at ? x : x + 1.0; }, [](double) { return 1.0; }, 1.0, 1.2);
    CHECK(jump.verdict != Verdict::differs);
    const auto root = comparison([&](double x) { return std::pow(std::max(x - at, 0.0), 1.5); },
                                 [&](double x) { return 1.5 * std::sqrt(std::max(x - at, 0.0)); }, 1.0, 1.2);
    CHECK(root.verdict != Verdict::differs);
  }
}

TEST_CASE("poles are found, and steep places are none") {
  const auto at = [](const std::optional<Pole>& pole) { return pole ? pole->at : -1.0; };
  CHECK(at(pole_of([](double x) { return x / (1.0 - x * x / 1.7); })) == doctest::Approx(std::sqrt(1.7)));
  CHECK(at(pole_of([](double x) { return 1.0 / ((x - 1.2345) * (x - 1.2345)); })) == doctest::Approx(1.2345));
  CHECK(at(pole_of([](double x) { return 1.0 / std::sqrt(std::abs(x - 0.777)); })) == doctest::Approx(0.777));
  CHECK(at(pole_of([](double x) { return 1.0 / (x - 1.0); })) == doctest::Approx(1.0));  // on the grid
  CHECK_FALSE(pole_of([](double x) { return x < 1.3 ? 1.0 / (1.3 - x) : NAN; }));        // as it should be
  CHECK_FALSE(pole_of([](double x) { return std::sin(9.0 * x); }));
  CHECK_FALSE(pole_of([](double x) { return std::tanh(1e6 * (x - 1.111)); }));
  CHECK_FALSE(pole_of([](double x) { return x < 1.5 ? 1.0 : -1.0; }));
  CHECK_FALSE(pole_of([](double x) { return std::exp(-1e4 * (x - 0.605) * (x - 0.605)); }));
  CHECK_FALSE(pole_of([](double x) { return 1.0 / x; }));  // at the end of the grid
  // Noise on nothing.
  std::mt19937_64 random(5);
  for (int k = 0; k < 20; ++k) {
    CHECK_FALSE(pole_of([&](double) { return random() % 64 == 0 ? 1e-12 : 0.0; }));
    CHECK_FALSE(pole_of([&](double) { return random() % 2 == 0 ? 1e-12 : 0.0; }));
  }
}
