// The search by itself: problems whose solutions are known.

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/QR>

#include <springnet/error.hpp>

#include "generator.hpp"
#include "learning/minimise.hpp"

using namespace springnet;
using namespace springnet::learning;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using springnet::testing::Dice;

namespace {

struct Linear : LeastSquares {
  MatrixXd a;
  VectorXd b;
  VectorXd residuals(const VectorXd& x) override { return a * x - b; }
  void linearise(const VectorXd&) override {}
  VectorXd times(const VectorXd& change) override { return a * change; }
  VectorXd transposed_times(const VectorXd& weights) override { return a.transpose() * weights; }
  MatrixXd jacobian(Index) override { return a; }
};

// Powell's badly scaled valley: 10 (y - x^2), 1 - x; nan beyond x = 3.
struct Rosenbrock : LeastSquares {
  VectorXd at;
  VectorXd residuals(const VectorXd& x) override {
    if (x[0] > 3.0) return VectorXd::Constant(2, std::numeric_limits<double>::quiet_NaN());
    return VectorXd{{10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]}};
  }
  void linearise(const VectorXd& x) override { at = x; }
  MatrixXd jacobian(Index) override { return MatrixXd{{-20.0 * at[0], 10.0}, {-1.0, 0.0}}; }
  VectorXd times(const VectorXd& change) override { return jacobian(2) * change; }
  VectorXd transposed_times(const VectorXd& weights) override { return jacobian(2).transpose() * weights; }
};

Bounds no_bounds(Index size) {
  const double infinite = std::numeric_limits<double>::infinity();
  return {VectorXd::Constant(size, -infinite), VectorXd::Constant(size, infinite)};
}

struct Method {
  std::string name;
  Minimum (*search)(LeastSquares&, const VectorXd&, const Bounds&, const MinimiseOptions&);
  Index most_dense;
};
const Method methods[] = {{"Jacobians", levenberg_marquardt, 2000},
                          {"products", levenberg_marquardt, 0},
                          {"L-BFGS", lbfgs, 0},
                          {"descent", gradient_descent, 0}};

MinimiseOptions many_iterations(const Method& method) {
  MinimiseOptions options;
  options.most_dense = method.most_dense;
  options.max_iterations = 100000;
  options.cost_tolerance = 1e-15;
  return options;
}

// The minimum, as that of the variables that are free in one of the 3^n ways to set each to a bound or free: the one
// within the bounds that costs least.
VectorXd by_active_sets(const Linear& problem, const Bounds& bounds) {
  const Index count = bounds.lower.size();
  VectorXd best;
  double least = std::numeric_limits<double>::infinity();
  Index ways = 1;
  for (Index k = 0; k < count; ++k) ways *= 3;
  for (Index way = 0; way < ways; ++way) {
    VectorXd x = VectorXd::Zero(count);
    std::vector<Index> free;
    bool is_possible = true;
    Index rest = way;
    for (Index k = 0; k < count; ++k, rest /= 3) {
      if (rest % 3 == 0) free.push_back(k);
      if (rest % 3 == 1) x[k] = bounds.lower[k];
      if (rest % 3 == 2) x[k] = bounds.upper[k];
      is_possible = is_possible && std::isfinite(x[k]);
    }
    if (!is_possible) continue;
    if (!free.empty()) {
      const VectorXd solution = problem.a(Eigen::all, free).colPivHouseholderQr().solve(problem.b - problem.a * x);
      x(free) = solution;
    }
    if (!((x.array() >= bounds.lower.array()).all() && (x.array() <= bounds.upper.array()).all())) continue;
    const double cost = (problem.a * x - problem.b).squaredNorm();
    if (cost < least) {
      least = cost;
      best = x;
    }
  }
  return best;
}

}  // namespace

TEST_CASE("random linear problems with bounds have the minimum of the best active set, whatever the method") {
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    constexpr Index count = 4;
    Linear problem;
    problem.a.resize(10, count);
    problem.b.resize(10);
    for (Index i = 0; i < 10; ++i) {
      const double common = dice.between(-1, 1);
      for (Index j = 0; j < count; ++j) problem.a(i, j) = common + 0.3 * dice.between(-1, 1);
      problem.b[i] = dice.between(-2, 2);
    }
    // Variables of other units, some without a bound, one that stays.
    Bounds bounds = no_bounds(count);
    VectorXd start(count), unit(count);
    for (Index k = 0; k < count; ++k) {
      unit[k] = dice.decades(1e-3, 1e3);
      problem.a.col(k) /= unit[k];
      if (dice.chance(0.7)) bounds.lower[k] = unit[k] * dice.between(-2, 0);
      if (dice.chance(0.7)) bounds.upper[k] = unit[k] * dice.between(0, 2);
      if (dice.chance(0.1)) bounds.lower[k] = bounds.upper[k] = 0.0;
      start[k] = dice.chance(0.2) && std::isfinite(bounds.upper[k]) ? bounds.upper[k] : 0.0;
    }
    const VectorXd right = by_active_sets(problem, bounds);
    for (const Method& method : methods) {
      CAPTURE(method.name);
      MinimiseOptions options = many_iterations(method);
      options.unit = unit;
      const Minimum found = method.search(problem, start, bounds, options);
      CAPTURE(found.reason);
      CHECK((found.x.array() >= bounds.lower.array()).all());
      CHECK((found.x.array() <= bounds.upper.array()).all());
      // The cost is known to its rounding, so x to its root, times what correlated columns amplify.
      CHECK((found.x - right).cwiseQuotient(unit).norm() < 1e-5);
      for (std::size_t k = 1; k < found.history.size(); ++k) CHECK(found.history[k].cost <= found.history[k - 1].cost);
      // Those at their bounds are there exactly.
      for (Index k = 0; k < count; ++k)
        if (found.history.back().gradient < 1e-9 && (right[k] == bounds.lower[k] || right[k] == bounds.upper[k]))
          CHECK(std::abs(found.x[k] - right[k]) < 1e-7 * unit[k]);
    }
  }
}

TEST_CASE("a large problem with bounds is solved by products and gradients, to the conditions of a minimum") {
  constexpr Index count = 200;
  Dice dice(7);
  Linear problem;
  problem.a.resize(2 * count, count);
  problem.b.resize(2 * count);
  for (Index i = 0; i < 2 * count; ++i) {
    for (Index j = 0; j < count; ++j) problem.a(i, j) = dice.between(-1, 1);
    problem.b[i] = dice.between(-2, 2);
  }
  Bounds bounds = no_bounds(count);
  bounds.lower.setZero();
  bounds.upper.setConstant(0.05);
  for (const Method& method : methods) {
    CAPTURE(method.name);
    const Minimum found = method.search(problem, VectorXd::Constant(count, 0.02), bounds, many_iterations(method));
    CAPTURE(found.reason);
    CAPTURE(found.history.size());
    const VectorXd gradient = problem.transposed_times(problem.residuals(found.x));
    Index held = 0;
    for (Index k = 0; k < count; ++k) {
      CAPTURE(k);
      if (found.x[k] == 0.0) {
        CHECK(gradient[k] > -1e-5);
        ++held;
      } else if (found.x[k] == 0.05) {
        CHECK(gradient[k] < 1e-5);
        ++held;
      } else {
        CHECK(std::abs(gradient[k]) < 1e-5);
      }
    }
    CHECK(held > count / 4);
    CHECK(held < count);
    if (method.search == lbfgs) CHECK(found.history.size() < 30);
  }
}

TEST_CASE("a curved valley is followed, past values that are not admissible") {
  for (const Method& method : methods) {
    CAPTURE(method.name);
    Rosenbrock problem;
    MinimiseOptions options = many_iterations(method);
    options.cost_tolerance = 1e-10;
    options.step_tolerance = 1e-14;  // steps of a descent are shorter than its way by the valley's condition, 2500
    const Minimum found = method.search(problem, VectorXd{{2.9, -1.0}}, no_bounds(2), options);
    CAPTURE(found.reason);
    CAPTURE(found.history.size());
    // The cost falls by a factor in each iteration to its end at 0, so the gradient decides.
    CHECK((found.x - VectorXd::Ones(2)).norm() < 1e-8);
    for (std::size_t k = 1; k < found.history.size(); ++k) CHECK(found.history[k].cost <= found.history[k - 1].cost);
    if (method.search != gradient_descent) CHECK(found.history.size() < 100);
    // A bound on the way: the least of 100 (y - x^2)^2 + (1 - x)^2 with x <= 0.5 is at its edge.
    Bounds bounds = no_bounds(2);
    bounds.upper[0] = 0.5;
    const Minimum edge = method.search(problem, VectorXd{{-1.2, 1.0}}, bounds, options);
    CAPTURE(edge.reason);
    CHECK(edge.x[0] == 0.5);
    CHECK(edge.x[1] == doctest::Approx(0.25).epsilon(1e-6));
  }
}

TEST_CASE("a search that goes on from a state is the one that was not disturbed, to the bit") {
  for (const Method& method : methods) {
    CAPTURE(method.name);
    Rosenbrock problem;
    Bounds bounds = no_bounds(2);
    bounds.upper[0] = 0.9;
    const VectorXd start{{-1.2, 1.0}};
    MinimiseOptions options = many_iterations(method);
    options.max_iterations = 60;
    std::vector<std::string> states;
    options.on_state = [&](const std::string& state) { states.push_back(state); };
    const Minimum whole = method.search(problem, start, bounds, options);
    REQUIRE(states.size() == whole.history.size());
    options.on_state = nullptr;
    for (const std::size_t from : {std::size_t{0}, states.size() / 3, states.size() - 1}) {
      CAPTURE(from);
      Rosenbrock again;
      options.state = states[from];
      int told = 0;
      options.on_iteration = [&](const Progress& now, const VectorXd&) {
        CHECK(now.iteration == static_cast<int>(from) + told++);
        return true;
      };
      const Minimum rest = method.search(again, start, bounds, options);
      CHECK(rest.x == whole.x);
      CHECK(rest.cost == whole.cost);
      CHECK(rest.reason == whole.reason);
      REQUIRE(rest.history.size() == whole.history.size());
      for (std::size_t k = 0; k < rest.history.size(); ++k) CHECK(rest.history[k].cost == whole.history[k].cost);
    }
    for (const std::string& bad : {states[0].substr(1), states[0] + "x", std::string("nothing")}) {
      options.state = bad;
      CHECK_THROWS_AS(method.search(problem, start, bounds, options), Error);
    }
  }
}

TEST_CASE("a descent whose first rate is far too great for the valley further on does not blow up") {
  // A slope that steepens: exp(8 x) - 1 is flat where the search begins, and steep beyond the minimum at 0.
  struct Steep : LeastSquares {
    double at = 0.0;
    VectorXd residuals(const VectorXd& x) override { return VectorXd{{std::exp(8.0 * x[0]) - 1.0}}; }
    void linearise(const VectorXd& x) override { at = x[0]; }
    VectorXd times(const VectorXd& change) override { return 8.0 * std::exp(8.0 * at) * change; }
    VectorXd transposed_times(const VectorXd& weights) override { return times(weights); }
    MatrixXd jacobian(Index) override { return times(VectorXd::Ones(1)); }
  } problem;
  const Method& method = methods[3];
  const Minimum found = method.search(problem, VectorXd{{-1.0}}, no_bounds(1), many_iterations(method));
  CAPTURE(found.reason);
  CHECK(std::abs(found.x[0]) < 1e-9);
  for (std::size_t k = 1; k < found.history.size(); ++k) CHECK(found.history[k].cost < found.history[k - 1].cost);
}

TEST_CASE("what a search cannot begin with is refused, and it stops when asked") {
  for (const Method& method : methods) {
    CAPTURE(method.name);
    Rosenbrock problem;
    CHECK_THROWS_AS(method.search(problem, VectorXd{{4.0, 0.0}}, no_bounds(2), {}), Error);
    CHECK_THROWS_AS(method.search(problem, VectorXd{{1.0, 0.0}}, no_bounds(3), {}), Error);
    Bounds outside = no_bounds(2);
    outside.lower[0] = 2.0;
    CHECK_THROWS_AS(method.search(problem, VectorXd{{1.0, 0.0}}, outside, {}), Error);
    MinimiseOptions options;
    options.unit = VectorXd{{1.0, 0.0}};
    CHECK_THROWS_AS(method.search(problem, VectorXd{{1.0, 0.0}}, no_bounds(2), options), Error);
    options.unit.resize(0);
    options.on_iteration = [](const Progress& now, const VectorXd&) { return now.iteration < 2; };
    const Minimum found = method.search(problem, VectorXd{{-1.2, 1.0}}, no_bounds(2), options);
    CHECK(found.stop == Minimum::Stop::asked);
    CHECK(found.history.size() == 3);
    CHECK(found.cost == found.history.back().cost);
    options.on_iteration = nullptr;
    options.max_iterations = 3;
    CHECK(method.search(problem, VectorXd{{-1.2, 1.0}}, no_bounds(2), options).stop == Minimum::Stop::iterations);
  }
}
