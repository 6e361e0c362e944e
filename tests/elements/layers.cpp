// Elements in the layers: forces and derivatives of whole nets, single nodes.
#include <cmath>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include <Eigen/Dense>

#include "../layers/random_net.hpp"
#include "bodies.hpp"
#include "layers/elements/queries.hpp"
#include "layers/linear/linearisation.hpp"
#include "layers/springs/queries.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Forces of all nodes, x of all first.
Eigen::VectorXd forces(EvaluatorFixture& fixture) {
  fixture.evaluate();
  const auto n = static_cast<Eigen::Index>(fixture.layout.node_count());
  Eigen::VectorXd result(3 * n);
  for (Eigen::Index c = 0; c < 3; ++c)
    result.segment(c * n, n) = Eigen::Map<const Eigen::VectorXd>(fixture.f[c].data(), n);
  return result;
}

}  // namespace

TEST_CASE("forces are minus the gradient of the energy") {
  const Network net = all_kinds(3, false);
  EvaluatorFixture fixture(net);
  const auto energy = [&] {
    const InstructionSet set = fixture.evaluator->instruction_set();
    return layers::spring_energy(fixture.layout, set, 0.0, fixture.nodes()) +
           layers::element_energy(fixture.layout, set, 0.0, fixture.nodes());
  };
  fixture.external.gravity.setZero();
  const Eigen::VectorXd found = forces(fixture);
  const auto n = static_cast<Eigen::Index>(fixture.layout.node_count());
  for (Eigen::Index i = 0; i < 3 * n; ++i) {
    double& coordinate = fixture.p[i / n][static_cast<std::size_t>(i % n)];
    const double value = coordinate;
    const auto at = [&](double h) {
      coordinate = value + h;
      const double there = energy();
      coordinate = value;
      return there;
    };
    constexpr double h = 1e-3;
    const double slope =
        (45.0 * (at(h) - at(-h)) - 9.0 * (at(2 * h) - at(-2 * h)) + (at(3 * h) - at(-3 * h))) / (60 * h);
    // Rounding of an energy of some tens over h; sixth order in h, of angles between nodes that may be 0.1 m apart.
    CHECK(std::abs(found[i] + slope) < 1e-7 * (1.0 + found.cwiseAbs().maxCoeff()));
  }
}

TEST_CASE(
    "the Jacobian is the derivative of the elements' forces; its systems are solved, transposed and constrained, too") {
  const Network net = all_kinds(21);
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
  for (Eigen::Index j = 0; j < size; ++j) {
    for (const bool velocity : {false, true}) {
      const auto c = static_cast<std::size_t>(j / n), k = static_cast<std::size_t>(j % n);
      std::vector<double>& array = velocity ? fixture.v[c] : fixture.p[c];
      const double value = array[k];
      const auto at = [&](double h) {
        array[k] = value + h;
        Eigen::VectorXd a = forces(fixture);
        array[k] = value;
        for (Eigen::Index i = 0; i < size; ++i) {
          const auto node = static_cast<std::size_t>(i % n);
          a[i] = constrained[node] != 0 ? 0.0 : a[i] / fixture.mass[node];
        }
        return a;
      };
      constexpr double h = 4e-4;
      const Eigen::VectorXd difference =
          (45.0 * (at(h) - at(-h)) - 9.0 * (at(2 * h) - at(-2 * h)) + (at(3 * h) - at(-3 * h))) / (60.0 * h);
      const Eigen::VectorXd analytic = (velocity ? by_v : by_p).col(j);
      // h^6 times seventh derivatives of angles with sides of some 0.1 m, and rounding / h: far below 1e-6.
      CHECK((difference - analytic).cwiseAbs().maxCoeff() <= 1e-6 * (1.0 + analytic.cwiseAbs().maxCoeff()));
    }
  }

  const double wv = 0.07, wp = 0.0049;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(size, size) - wv * by_v - wp * by_p;
  for (Eigen::Index i = 0; i < size; ++i)
    if (constrained[static_cast<std::size_t>(i % n)] != 0) dense.row(i) = Eigen::VectorXd::Unit(size, i).transpose();
  CHECK((dense - dense.transpose()).cwiseAbs().maxCoeff() > 1e-3);
  REQUIRE(linearisation.factorise(wv, wp, {}, message) == SPRINGNET_OK);
  const Eigen::VectorXd right_hand_side = Eigen::VectorXd::LinSpaced(size, -1.0, 2.0);
  Eigen::VectorXd x(size);
  // Solved to rounding of a system with entries up to some hundreds.
  REQUIRE(linearisation.solve(false, right_hand_side.data(), x.data(), message) == SPRINGNET_OK);
  CHECK((dense * x - right_hand_side).norm() <= 1e-10 * right_hand_side.norm());
  REQUIRE(linearisation.solve(true, right_hand_side.data(), x.data(), message) == SPRINGNET_OK);
  CHECK((dense.transpose() * x - right_hand_side).norm() <= 1e-10 * right_hand_side.norm());

  std::vector<double> blocks(9 * std::size_t{n});
  linearisation.diagonal_blocks(wv, wp, blocks.data());
  for (std::uint32_t k = 0; k < n; ++k)
    for (Eigen::Index r = 0; r < 3; ++r)
      for (Eigen::Index c = 0; c < 3; ++c)
        CHECK(blocks[9 * k + 3 * static_cast<std::size_t>(r) + static_cast<std::size_t>(c)] ==
              doctest::Approx(dense(r * n + k, c * n + k)).epsilon(1e-11));

  // Constrained by a row between nodes of the surface: A x + W G^T y = b, G x = G b.
  const std::uint32_t a = fixture.layout.ordering().engine[15], b = fixture.layout.ordering().engine[20];
  const Vector3 direction = Vector3(1, 2, -1).normalized();
  REQUIRE(linearisation.factorise(wv, wp, {{a, b, direction}}, message) == SPRINGNET_OK);
  REQUIRE(linearisation.solve(false, right_hand_side.data(), x.data(), message) == SPRINGNET_OK);
  Eigen::VectorXd g = zero, mobile = zero;
  for (Eigen::Index c = 0; c < 3; ++c) {
    g[c * n + a] = direction[c];
    g[c * n + b] = -direction[c];
    mobile[c * n + a] = constrained[a] != 0 ? 0.0 : direction[c] / fixture.mass[a];
    mobile[c * n + b] = constrained[b] != 0 ? 0.0 : -direction[c] / fixture.mass[b];
  }
  const Eigen::VectorXd left = dense * x - right_hand_side;
  CHECK(std::abs(g.dot(x - right_hand_side)) <= 1e-9);  // the rows are regularised by 1e-12
  CHECK((left - mobile * (mobile.dot(left) / mobile.squaredNorm())).norm() <= 1e-10 * right_hand_side.norm());
}

TEST_CASE("a single node has the force and the blocks of the whole net") {
  const Network net = all_kinds(8);
  EvaluatorFixture fixture(net);
  const std::uint32_t n = fixture.layout.node_count();
  const std::vector<std::uint8_t> constrained(n, 0);
  layers::Linearisation linearisation(fixture.layout, *fixture.evaluator, constrained);
  springnet_message message{};
  REQUIRE(linearisation.update(0.0, fixture.nodes(), fixture.external, message) == SPRINGNET_OK);
  fixture.evaluate();
  std::vector<double> by_velocity(9 * std::size_t{n}), by_position(9 * std::size_t{n});
  linearisation.diagonal_blocks(1.0, 0.0, by_velocity.data());
  linearisation.diagonal_blocks(0.0, 1.0, by_position.data());
  layers::EnclosureVolumes volumes;
  volumes.compute(fixture.layout.elements(), fixture.nodes());
  for (std::uint32_t k = 0; k < n; ++k) {
    for (const layers::EnclosureVolumes* known : {static_cast<const layers::EnclosureVolumes*>(nullptr),
                                                  static_cast<const layers::EnclosureVolumes*>(&volumes)}) {
      Vector3 force, acceleration;
      layers::NodeDerivatives derivatives{};
      REQUIRE(fixture.evaluator->evaluate_node(k, 0.0, fixture.nodes(), fixture.external, known, force, acceleration,
                                               &derivatives, nullptr, message) == SPRINGNET_OK);
      // Other orders of the same sums, of forces of order 10 and blocks of order 100.
      CHECK((force - Vector3(fixture.f[0][k], fixture.f[1][k], fixture.f[2][k])).norm() < 1e-12);
      for (std::size_t i = 0; i < 9; ++i) {
        const double one = i % 4 == 0 ? 1.0 : 0.0;
        CHECK(std::abs(one - derivatives.by_velocity[i] - by_velocity[9 * k + i]) < 1e-11);
        CHECK(std::abs(one - derivatives.by_position[i] - by_position[9 * k + i]) < 1e-11);
      }
    }
  }
}

TEST_CASE("volumes follow nodes that move one after another") {
  const Network net = all_kinds(8);
  EvaluatorFixture fixture(net);
  layers::EnclosureVolumes volumes;
  volumes.follow(fixture.layout.elements(), fixture.nodes());
  const layers::Enclosure& enclosure = fixture.layout.elements().enclosures()[0].shape;
  for (std::size_t place = 0; place < enclosure.size(); ++place) {
    const std::uint32_t k = enclosure.nodes()[place];
    for (std::size_t c = 0; c < 3; ++c) {
      fixture.p[c][k] += 0.1 * static_cast<double>(c + 1);
      fixture.v[c][k] -= 0.3;
    }
    const layers::Enclosure::Values exact = enclosure.values(fixture.nodes());
    const layers::Enclosure::Values seen = volumes.values_for(k, 0, enclosure.gradient(place, fixture.nodes()),
                                                              enclosure.rate_gradient(place, fixture.nodes()));
    CHECK(std::abs(seen.volume - exact.volume) < 1e-12);  // rounding
    CHECK(std::abs(seen.rate - exact.rate) < 1e-12);
    volumes.commit(k);
  }
}

TEST_CASE("a law is refused where it needs an input that its element does not have") {
  Network net = all_kinds(1);
  const MaterialIndex relative = net.add_material({std::nullopt, LawUse{"relative", {{"damping", 1.0}}}});
  net.add_element(Invariant::area, {0, 1, 2}, relative);
  CHECK_THROWS_WITH_AS(EvaluatorFixture fixture(net),
                       doctest::Contains("(area): viscosity function 'relative' reads the relative speed"), Error);
}
