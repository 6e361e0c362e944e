// The rules for the weight of the guess on linear problems, whose searches are known in closed form.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "generator.hpp"
#include "learning/guess_weight.hpp"

using namespace springnet::learning;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using springnet::testing::Dice;

namespace {

// Of a badly determined x: singular values from 1e3 to 1e-3, noise of deviation 1.
struct Tikhonov {
  explicit Tikhonov(std::uint64_t seed, double noise = 1.0) {
    Dice dice(seed);
    const auto at_random = [&](Index rows, Index columns) {
      return MatrixXd(MatrixXd::NullaryExpr(rows, columns, [&] { return dice.between(-1, 1); }));
    };
    const MatrixXd left = at_random(80, 80).householderQr().householderQ();
    const MatrixXd right = at_random(13, 13).householderQr().householderQ();
    VectorXd values(13);
    for (Index k = 0; k < 13; ++k) values[k] = std::pow(10.0, 3.0 - 0.5 * static_cast<double>(k));
    a = left.leftCols(13) * values.asDiagonal() * right.transpose();
    truth = at_random(13, 1);
    b = a * truth;
    for (double& each : b)
      for (int i = 0; i < 12; ++i) each += noise * dice.between(-0.5, 0.5);
  }
  [[nodiscard]] VectorXd solution(double weight) const {
    return (a.transpose() * a + weight * MatrixXd::Identity(13, 13)).ldlt().solve(a.transpose() * b);
  }
  [[nodiscard]] double rms(const VectorXd& x) const { return (a * x - b).norm() / std::sqrt(80.0); }
  [[nodiscard]] double error(double weight) const { return (solution(weight) - truth).norm(); }
  [[nodiscard]] GuessSearch search() const {
    return [this](double weight, const VectorXd*) {
      const VectorXd x = solution(weight);
      return GuessTrial{{weight, rms(x), x.norm()}, x};
    };
  }
  MatrixXd a;
  VectorXd b, truth;
};

constexpr double greatest = 1e6;

}  // namespace

TEST_CASE("by discrepancy the weight is the greatest with which the differences are within the noise") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    const Tikhonov problem(seed, 0.7);  // the least rms is 0.64, deviation 0.05
    // From far above, and from below.
    for (const double from : {1e8 * greatest, 1e-6 * greatest}) {
      const GuessChoice choice = weight_by_discrepancy(from, problem.rms(VectorXd::Zero(13)), 80, problem.search());
      const double weight = choice.found.point.weight;
      CHECK(choice.note.empty());
      CHECK(problem.rms(problem.solution(weight)) <= 1.0);
      const bool is_near = problem.rms(problem.solution(1.11 * weight)) > 1.0 || choice.found.point.rms > 0.998;
      CHECK(is_near);
      CHECK(choice.curve.size() <= 25);
      CHECK(std::is_sorted(choice.curve.begin(), choice.curve.end(),
                           [](const auto& x, const auto& y) { return x.weight > y.weight; }));
    }
  }
}

TEST_CASE("a discrepancy that no weight reaches, or that the guess has, is told") {
  const Tikhonov noisy(1, 1.5);
  const GuessChoice never = weight_by_discrepancy(greatest, noisy.rms(VectorXd::Zero(13)), 80, noisy.search());
  CHECK(never.found.point.rms > 1.0);
  CHECK(never.note.find("they are too small") != std::string::npos);
  CHECK(never.found.point.weight == never.curve.back().weight);
  Tikhonov known(2);
  known.b *= 0.01;
  const GuessChoice nothing = weight_by_discrepancy(greatest, known.rms(VectorXd::Zero(13)), 80, known.search());
  CHECK(nothing.note.find("no reason to leave it") != std::string::npos);
  CHECK(nothing.curve.size() == 1);
}

TEST_CASE("the L-curve's corner is where the error is nearly the least") {
  int near = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    const Tikhonov problem(seed);
    const GuessChoice choice = weight_by_l_curve(greatest, problem.search());
    CHECK(choice.note.empty());
    double least = problem.error(greatest);
    for (int k = 1; k <= 80; ++k) least = std::min(least, problem.error(greatest * std::pow(10.0, -0.15 * k)));
    if (problem.error(choice.found.point.weight) < 2.0 * least) ++near;
    // Without a guess the error is some hundreds.
    CHECK(problem.error(choice.found.point.weight) < 0.05 * problem.error(0.0));
  }
  CHECK(near >= 15);
  const GuessSearch straight = [](double weight, const VectorXd*) {
    return GuessTrial{{weight, std::sqrt(weight), 1.0 / weight}, VectorXd::Zero(1)};
  };
  CHECK(weight_by_l_curve(1.0, straight).note.find("no corner") != std::string::npos);
}

TEST_CASE("a search that is stopped ends the choice") {
  int count = 0;
  const Tikhonov problem(3);
  const GuessSearch stopping = [&](double weight, const VectorXd* from) {
    GuessTrial found = problem.search()(weight, from);
    found.stopped = ++count == 3;
    return found;
  };
  CHECK(weight_by_discrepancy(greatest, 100.0, 80, stopping).found.stopped);
  CHECK(count == 3);
  count = 0;
  CHECK(weight_by_l_curve(greatest, stopping).found.stopped);
  CHECK(count == 3);
}
