// The search by itself: problems whose solutions are known.

#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

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

// Within bounds of 0: the gradient is 0 where x is above 0, and points inwards where x is 0.
double violation(Linear& problem, const VectorXd& x) {
  const VectorXd gradient = problem.transposed_times(problem.residuals(x));
  double worst = 0.0;
  for (Index k = 0; k < x.size(); ++k)
    worst = std::max(worst, x[k] > 0.0 ? std::abs(gradient[k]) : std::max(0.0, -gradient[k]));
  return worst;
}

}  // namespace

TEST_CASE("linear problems with bounds and correlated columns are solved, with Jacobians and with products") {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    Linear problem;
    problem.a.resize(10, 4);
    problem.b.resize(10);
    for (Index i = 0; i < 10; ++i) {
      const double common = dice.between(-1, 1);
      for (Index j = 0; j < 4; ++j) problem.a(i, j) = common + 0.3 * dice.between(-1, 1);
      problem.b[i] = dice.between(-2, 2);
    }
    Bounds bounds = no_bounds(4);
    bounds.lower.setZero();
    for (const Index dense : {2000, 0}) {
      CAPTURE(dense);
      MinimiseOptions options;
      options.most_dense = dense;
      options.max_iterations = 1000;
      options.cost_tolerance = 1e-15;
      const Minimum found = levenberg_marquardt(problem, VectorXd::Ones(4), bounds, options);
      CAPTURE(found.reason);
      CHECK(found.x.minCoeff() >= 0.0);
      CHECK(violation(problem, found.x) < 1e-6);
    }
  }
}

TEST_CASE("a curved valley is followed, past values that are not admissible") {
  for (const Index dense : {2000, 0}) {
    Rosenbrock problem;
    MinimiseOptions options;
    options.most_dense = dense;
    options.max_iterations = 500;
    const Minimum found = levenberg_marquardt(problem, VectorXd{{2.9, -1.0}}, no_bounds(2), options);
    CAPTURE(found.reason);
    CHECK((found.x - VectorXd::Ones(2)).norm() < 1e-9);
    for (std::size_t k = 1; k < found.history.size(); ++k) CHECK(found.history[k].cost <= found.history[k - 1].cost);
    // A bound on the way: the least of 100 (y - x^2)^2 + (1 - x)^2 with x <= 0.5 is at its edge.
    Bounds bounds = no_bounds(2);
    bounds.upper[0] = 0.5;
    const Minimum edge = levenberg_marquardt(problem, VectorXd{{-1.2, 1.0}}, bounds, options);
    CHECK((edge.x - VectorXd{{0.5, 0.25}}).norm() < 1e-7);
  }
}

TEST_CASE("what a search cannot begin with is refused, and it stops when asked") {
  Rosenbrock problem;
  CHECK_THROWS_AS(levenberg_marquardt(problem, VectorXd{{4.0, 0.0}}, no_bounds(2)), Error);
  CHECK_THROWS_AS(levenberg_marquardt(problem, VectorXd{{1.0, 0.0}}, no_bounds(3)), Error);
  Bounds outside = no_bounds(2);
  outside.lower[0] = 2.0;
  CHECK_THROWS_AS(levenberg_marquardt(problem, VectorXd{{1.0, 0.0}}, outside), Error);
  MinimiseOptions options;
  options.on_iteration = [](const Progress& now, const VectorXd&) { return now.iteration < 2; };
  const Minimum found = levenberg_marquardt(problem, VectorXd{{-1.2, 1.0}}, no_bounds(2), options);
  CHECK(found.stop == Minimum::Stop::asked);
  CHECK(found.history.size() == 3);
  CHECK(found.cost == found.history.back().cost);
}
