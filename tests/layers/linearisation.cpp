// Derivatives of the accelerations against central differences, and the linear systems against dense ones.

#include <doctest/doctest.h>

#include <Eigen/Dense>

#include "layers/linear/linearisation.hpp"
#include "random_net.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Accelerations of all nodes, x of all first.
Eigen::VectorXd accelerations(EvaluatorFixture& fixture, const std::vector<std::uint8_t>& constrained) {
  fixture.evaluate();
  const auto n = static_cast<Eigen::Index>(fixture.layout.node_count());
  Eigen::VectorXd result(3 * n);
  const double* force[3] = {fixture.f[0].data(), fixture.f[1].data(), fixture.f[2].data()};
  double* out[3] = {result.data(), result.data() + n, result.data() + 2 * n};
  springnet_message message{};
  REQUIRE(fixture.evaluator->accelerations(0, static_cast<std::uint32_t>(n), 0.0, fixture.nodes(), force, out, nullptr,
                                           nullptr, nullptr, message) == SPRINGNET_OK);
  for (Eigen::Index i = 0; i < 3 * n; ++i)
    if (constrained[static_cast<std::size_t>(i % n)] != 0) result[i] = 0.0;
  return result;
}

}  // namespace

TEST_CASE("the Jacobian is the derivative of the forces, and its systems are solved") {
  const Network net = random_network(25, 4, 21);
  EvaluatorFixture fixture(net);
  const std::uint32_t n = fixture.layout.node_count();
  std::vector<std::uint8_t> constrained(n, 0);
  constrained[3] = constrained[17] = 1;
  layers::Linearisation linearisation(fixture.layout, *fixture.evaluator, constrained);
  springnet_message message{};
  REQUIRE(linearisation.update(0.0, fixture.nodes(), fixture.external, message) == SPRINGNET_OK);

  const auto size = static_cast<Eigen::Index>(3 * n);
  Eigen::MatrixXd by_p(size, size), by_v(size, size);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(size, j);
    linearisation.times(unit.data(), zero.data(), by_p.col(j).data());
    linearisation.times(zero.data(), unit.data(), by_v.col(j).data());
  }

  // Fourth-order central differences: error of h^4 and of rounding / h, both below 1e-8 of entries of order 10.
  constexpr double h = 4e-4, tolerance = 1e-7;
  for (Eigen::Index j = 0; j < size; ++j) {
    for (const bool velocity : {false, true}) {
      // Not (velocity ? fixture.v : fixture.p)[c]: GCC 12 with -fsanitize=bounds reads a wrong index there.
      const auto c = static_cast<std::size_t>(j / n);
      std::vector<double>& array = velocity ? fixture.v[c] : fixture.p[c];
      const auto k = static_cast<std::size_t>(j % n);
      const double value = array[k];
      const auto at = [&](double step) {
        array[k] = value + step;
        Eigen::VectorXd a = accelerations(fixture, constrained);
        array[k] = value;
        return a;
      };
      const Eigen::VectorXd difference = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
      const Eigen::VectorXd analytic = (velocity ? by_v : by_p).col(j);
      CHECK((difference - analytic).cwiseAbs().maxCoeff() <= tolerance * (1.0 + analytic.cwiseAbs().maxCoeff()));
    }
  }

  const double wv = 0.07, wp = 0.0049;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(size, size) - wv * by_v - wp * by_p;
  for (Eigen::Index i = 0; i < size; ++i)  // rows of constrained nodes are those of the identity
    if (constrained[static_cast<std::size_t>(i % n)] != 0) dense.row(i) = Eigen::VectorXd::Unit(size, i).transpose();
  CHECK((dense - dense.transpose()).cwiseAbs().maxCoeff() > 1e-3);  // so the transposed solve is tested at all
  REQUIRE(linearisation.factorise(wv, wp, {}, message) == SPRINGNET_OK);
  const Eigen::VectorXd right_hand_side = Eigen::VectorXd::LinSpaced(size, -1.0, 2.0);
  Eigen::VectorXd x(size);
  REQUIRE(linearisation.solve(false, right_hand_side.data(), x.data(), message) == SPRINGNET_OK);
  // Well conditioned systems of 75 unknowns, solved to rounding.
  CHECK((dense * x - right_hand_side).norm() <= 1e-11 * right_hand_side.norm());
  REQUIRE(linearisation.solve(true, right_hand_side.data(), x.data(), message) == SPRINGNET_OK);
  CHECK((dense.transpose() * x - right_hand_side).norm() <= 1e-11 * right_hand_side.norm());

  std::vector<double> blocks(9 * std::size_t{n});
  linearisation.diagonal_blocks(wv, wp, blocks.data());
  for (std::uint32_t k = 0; k < n; ++k)
    for (Eigen::Index r = 0; r < 3; ++r)
      for (Eigen::Index c = 0; c < 3; ++c)
        CHECK(blocks[9 * k + 3 * static_cast<std::size_t>(r) + static_cast<std::size_t>(c)] ==
              doctest::Approx(dense(r * n + k, c * n + k)).epsilon(1e-12));
}

TEST_CASE("a drag between nodes that are no neighbours is in products, systems, transposed ones and blocks") {
  const Network net = random_network(12, 3, 5);
  EvaluatorFixture fixture(net);
  const std::uint32_t n = fixture.layout.node_count();
  std::vector<std::uint8_t> constrained(n, 0);
  constrained[4] = 1;
  layers::Linearisation linearisation(fixture.layout, *fixture.evaluator, constrained);
  springnet_message message{};
  const auto size = static_cast<Eigen::Index>(3 * n);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
  const auto by_velocity = [&] {
    Eigen::MatrixXd result(size, size);
    for (Eigen::Index j = 0; j < size; ++j)
      linearisation.times(zero.data(), Eigen::VectorXd(Eigen::VectorXd::Unit(size, j)).data(), result.col(j).data());
    return result;
  };
  REQUIRE(linearisation.update(0.0, fixture.nodes(), fixture.external, message) == SPRINGNET_OK);
  const Eigen::MatrixXd without = by_velocity();
  ConstraintRow row{0, 4, Vector3(0.6, 0.0, 0.8)};
  row.third = 7;
  row.fourth = 9;
  row.weights = {1.0, -0.2, -0.5, -0.3};
  const double damping = 3.0;
  linearisation.add_drag(row, damping);
  const Eigen::MatrixXd with = by_velocity();
  // On each node -damping w (sum of w v) along the direction, over its mass.
  Eigen::VectorXd gradient = zero, answer = zero;
  row.for_each_end([&](std::size_t, std::uint32_t k, double weight) {
    if (constrained[k] != 0) return;
    const Eigen::Matrix3d mobility = linearisation.by_force(k);
    for (Eigen::Index c = 0; c < 3; ++c) {
      gradient[c * n + k] = weight * row.direction[c];
      answer[c * n + k] = weight * (mobility * row.direction)[c];
    }
  });
  CHECK((with - without + damping * answer * gradient.transpose()).norm() <= 1e-12 * with.norm());

  const double wv = 0.07, wp = 0.0049;
  Eigen::MatrixXd by_p(size, size);
  for (Eigen::Index j = 0; j < size; ++j)
    linearisation.times(Eigen::VectorXd(Eigen::VectorXd::Unit(size, j)).data(), zero.data(), by_p.col(j).data());
  const Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(size, size) - wv * with - wp * by_p;
  REQUIRE(linearisation.factorise(wv, wp, {}, message) == SPRINGNET_OK);
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(size, -1.0, 2.0);
  Eigen::VectorXd x(size), by_position(size), by_velocities(size);
  for (const bool transposed : {false, true}) {
    REQUIRE(linearisation.solve(transposed, right.data(), x.data(), message) == SPRINGNET_OK);
    CHECK(((transposed ? Eigen::MatrixXd(dense.transpose()) : dense) * x - right).norm() <= 1e-11 * right.norm());
  }
  linearisation.transposed_times(right.data(), by_position.data(), by_velocities.data());
  CHECK((by_velocities - with.transpose() * right).norm() <= 1e-12 * by_velocities.norm());
  std::vector<double> blocks(9 * std::size_t{n});
  linearisation.diagonal_blocks(wv, wp, blocks.data());
  for (std::uint32_t k = 0; k < n; ++k)
    for (Eigen::Index r = 0; r < 3; ++r)
      for (Eigen::Index c = 0; c < 3; ++c)
        CHECK(blocks[9 * k + 3 * static_cast<std::size_t>(r) + static_cast<std::size_t>(c)] ==
              doctest::Approx(dense(r * n + k, c * n + k)).epsilon(1e-12));
}
