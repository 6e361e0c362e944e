// Singular values by products against those of the whole matrix.

#include <cmath>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <Eigen/QR>

#include "learning/certainty.hpp"
#include "learning/fit.hpp"
#include "learning/lanczos.hpp"
#include "learning/many_variables.hpp"
#include "learning/svd.hpp"
#include "learning_nets.hpp"

using namespace springnet::learning;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// With orthogonal vectors at random.
MatrixXd with_singular_values(Index rows, const VectorXd& values) {
  const auto orthogonal = [](Index size, std::uint64_t seed) {
    return MatrixXd(arbitrary_vector(size * size, seed).reshaped(size, size).householderQr().householderQ());
  };
  const Index columns = values.size();
  return orthogonal(rows, 1).leftCols(columns) * values.asDiagonal() * orthogonal(columns, 2).transpose();
}

SingularValues found_in(const MatrixXd& a, const LanczosOptions& options) {
  return greatest_singular_values([&](const VectorXd& x) { return VectorXd(a * x); },
                                  [&](const VectorXd& y) { return VectorXd(a.transpose() * y); }, a.cols(), options);
}

}  // namespace

TEST_CASE("the greatest singular values and their vectors are those of the whole matrix") {
  VectorXd values(30);
  for (Index k = 0; k < 30; ++k) values[k] = std::pow(10.0, -0.2 * static_cast<double>(k));
  const MatrixXd a = with_singular_values(60, values);
  const Svd dense = right_svd(a);
  const SingularValues some = found_in(a, {18, 6, 1e-9});
  REQUIRE(some.values.size() == 6);
  CHECK_FALSE(some.all);
  for (Index k = 0; k < 6; ++k) {
    CHECK(some.values[k] == doctest::Approx(dense.values[k]).epsilon(1e-12));
    // The angle between vectors is the residual over the distance of the next value, 0.16 of the greatest at k = 5.
    CHECK(std::abs(some.right.col(k).dot(dense.right.col(k))) == doctest::Approx(1.0).epsilon(1e-12));
  }
  // What has not settled is not told.
  const SingularValues few = found_in(a, {4, 30, 1e-9});
  CHECK(few.values.size() < 4);
  // To the end, all but what is lost in rounding.
  const SingularValues whole = found_in(a, {100, 100, 1e-12});
  CHECK(whole.all);
  REQUIRE(whole.values.size() == 30);
  CHECK((whole.values - values).cwiseAbs().maxCoeff() < 1e-14);
}

TEST_CASE("equal singular values are found with the last of the products, and those that are 0 are none") {
  const VectorXd values{{3.0, 3.0, 3.0, 1.0, 1.0, 0.0, 0.0}};
  for (const Index rows : {7, 20}) {
    const SingularValues found = found_in(with_singular_values(rows, values), {100, 100, 1e-10});
    CHECK(found.all);
    REQUIRE(found.values.size() == 5);
    CHECK((found.values - values.head(5)).cwiseAbs().maxCoeff() < 1e-13);
    CHECK((found.right.transpose() * found.right - MatrixXd::Identity(5, 5)).cwiseAbs().maxCoeff() < 1e-12);
  }
  const SingularValues wide = found_in(with_singular_values(20, values).transpose(), {100, 100, 1e-10});
  CHECK(wide.values.size() == 5);
  CHECK(found_in(MatrixXd::Zero(3, 2), {}).values.size() == 0);
}

TEST_CASE("singular values of a motion's sensitivities by products are those of the whole Jacobian") {
  using namespace springnet;
  using namespace springnet::testing;
  Network net = chain(6, {0, 0, 0}, {1, 0, 0}, damped(40.0, 1.0));
  net.fix(0);
  net.set_gravity({0, 0, -2});
  const SimulationOptions options = to_learn_with(0.5, 0.05);
  Simulation real(net, plugins(), options);
  // Scales of several sizes: stiffnesses as they are, masses by their logarithm.
  const std::vector<Learnable> learnables{{{LearnedValues::Kind::spring_parameter, false, "stiffness", from_to(0, 5)}},
                                          {{LearnedValues::Kind::mass, false, "", from_to(1, 6)}}};
  for (const double guess_weight : {0.0, 0.1}) {
    Fit fit({experiment(net, options, observe(real, 20, {5}, 0.01))}, plugins(), learnables, guess_weight);
    fit.linearise(fit.variables().start());
    const MatrixXd jacobian = fit.times(MatrixXd(fit.variables().scale().asDiagonal())).topRows(fit.observation_rows());
    const Certainty dense(jacobian, VectorXd::Zero(fit.observation_rows()), fit.observed());
    const SingularValues found = singular_values(fit, {10, 10, 1e-9});
    REQUIRE(found.values.size() >= 8);
    for (Index k = 0; k < found.values.size(); ++k)
      CHECK(found.values[k] == doctest::Approx(dense.singular_values()[static_cast<std::size_t>(k)])
                                   .epsilon(1e-9 * found.values[0] / found.values[k]));
    real = Simulation(net, plugins(), options);
  }
}

TEST_CASE("what products have reached bounds what the guess gives, from above, and more of them bound it closer") {
  VectorXd values(30);
  for (Index k = 0; k < 30; ++k) values[k] = std::pow(10.0, -0.1 * static_cast<double>(k));
  const MatrixXd a = with_singular_values(60, values);
  const double weight = 0.01;
  const MatrixXd determined = a.transpose() * (a * a.transpose() + weight * MatrixXd::Identity(60, 60)).inverse() * a;
  const VectorXd share = determined.diagonal();
  VectorXd before = VectorXd::Zero(30);
  for (const Index products : {5, 10, 20, 30}) {
    const SingularValues found = found_in(a, {products, products, 1e-4});
    CHECK(found.reached.size() <= products + 1);
    VectorXd bound(30);
    for (Index i = 0; i < 30; ++i)
      bound[i] = found.reached_right.row(i).cwiseAbs2().dot(
          found.reached.cwiseAbs2().cwiseQuotient((found.reached.cwiseAbs2().array() + weight).matrix()));
    CHECK((bound - share).maxCoeff() <= 1e-12);
    CHECK((before - bound).maxCoeff() <= 1e-12);
    if (products == 10) CHECK(bound.sum() > 0.5 * share.sum());
    if (products == 30) CHECK(bound.isApprox(share, 1e-9));
    before = bound;
  }
}
