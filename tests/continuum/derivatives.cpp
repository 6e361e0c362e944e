// The derivatives of the forces of elements whose laws read several scalars; all methods on them.
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include "../layers/random_net.hpp"
#include "laws.hpp"
#include "layers/linear/linearisation.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct Case {
  std::string name;
  Invariant shape;
  Material material;
};
std::vector<Case> cases() {
  const LawUse solid = solid_law(2.0, 0.4), viscous = viscous_solid_law(0.5, 0.2);
  const LawUse fibres = fibre_solid_law({2.0, 0.4}, {3.0, 0.2, true, Vector3::UnitX()});
  const LawUse viscous_sheet = viscous_membrane_law(0.5, 0.2), shell = shell_law(2.0, 0.4, 0.5);
  const auto tetrahedron = Invariant::tetrahedron, triangle = Invariant::triangle;
  return {{"solid", tetrahedron, {solid, std::nullopt}},
          {"fibre_solid", tetrahedron, {fibres, std::nullopt}},
          {"viscous_solid", tetrahedron, {std::nullopt, viscous}},
          {"solid, viscous_solid", tetrahedron, {solid, viscous}},
          {"fibre_solid, viscous_solid", tetrahedron, {fibres, viscous}},
          {"neo-Hookean membrane", triangle, {membrane_law(2.0, 0.4, 0.5), std::nullopt}},
          {"St. Venant membrane", triangle, {membrane_law(2.0, 0.4, 0.5, false), std::nullopt}},
          {"viscous_membrane", triangle, {std::nullopt, viscous_sheet}},
          {"membrane, viscous_membrane", triangle, {membrane_law(2.0, 0.4, 0.5), viscous_sheet}},
          {"St. Venant membrane, viscous_membrane", triangle, {membrane_law(2.0, 0.4, 0.5, false), viscous_sheet}},
          {"shell", Invariant::hinge, {shell, std::nullopt}}};
}

// Nodes moved at random from a mesh at rest, by up to `strain` of its cells, in motion.
Network net_of(const Case& one, double strain, unsigned seed) {
  std::mt19937 random(seed);
  Network net;
  if (one.shape == Invariant::tetrahedron) {
    net = element_net(solid_mesh(2, Vector3(2.0, 2.0, 2.0), seed), one.material, Vector3(1.0, 2.0, 3.0));
  } else {
    const SimplexMesh<3> sheet = sheet_mesh(3, 3.0, 3.0, seed);
    net = element_net(
        sheet, one.shape == Invariant::triangle ? one.material : Material{membrane_law(1.0, 0.3, 0.1), std::nullopt});
    if (one.shape == Invariant::hinge) {
      const MaterialIndex index = net.add_material(one.material);
      for (const auto& hinge : hinges_of(sheet)) net.add_element(Invariant::hinge, {hinge.begin(), hinge.end()}, index);
    }
  }
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    node.position += strain * random_vector(random);
    node.velocity = random_vector(random);
    node.mass = 1.0 + 0.5 * random_unit(random);
    net.set_node(k, node);
  }
  return net;
}

Eigen::VectorXd accelerations(EvaluatorFixture& fixture) {
  fixture.evaluate();
  const auto n = static_cast<Eigen::Index>(fixture.layout.node_count());
  Eigen::VectorXd result(3 * n);
  for (Eigen::Index c = 0; c < 3; ++c)
    for (Eigen::Index k = 0; k < n; ++k)
      result[c * n + k] = fixture.f[c][static_cast<std::size_t>(k)] / fixture.mass[static_cast<std::size_t>(k)];
  return result;
}

std::vector<Vector3> positions(const Simulation& simulation) {
  std::vector<Vector3> result;
  for (NodeIndex k = 0; k < simulation.node_count(); ++k) result.push_back(simulation.position(k));
  return result;
}
double distance(const std::vector<Vector3>& a, const std::vector<Vector3>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]).squaredNorm();
  return std::sqrt(sum);
}

}  // namespace

TEST_CASE("the Jacobian of every law is the difference of its forces") {
  for (const Case& one : cases()) {
    CAPTURE(one.name);
    for (const InstructionSet set : {InstructionSet::best, InstructionSet::generic}) {
      EvaluatorFixture fixture(net_of(one, 0.3, 2), set);
      fixture.external.gravity.setZero();
      const std::uint32_t n = fixture.layout.node_count();
      const std::vector<std::uint8_t> constrained(n, 0);
      layers::Linearisation linearisation(fixture.layout, *fixture.evaluator, constrained);
      springnet_message message{};
      REQUIRE(linearisation.update(0.0, fixture.nodes(), fixture.external, message) == SPRINGNET_OK);
      const auto size = static_cast<Eigen::Index>(3 * n);
      const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
      std::vector<double> blocks(9 * std::size_t{n});
      linearisation.diagonal_blocks(0.3, 0.7, blocks.data());
      double greatest = 0.0, error = 0.0, block_error = 0.0;
      for (Eigen::Index j = 0; j < size; ++j) {
        Eigen::VectorXd column[2];
        for (const bool velocity : {false, true}) {
          const auto c = static_cast<std::size_t>(j / n), k = static_cast<std::size_t>(j % n);
          double& number = velocity ? fixture.v[c][k] : fixture.p[c][k];
          const double value = number;
          const auto at = [&](double h) {
            number = value + h;
            Eigen::VectorXd a = accelerations(fixture);
            number = value;
            return a;
          };
          constexpr double h = 4e-3;
          const Eigen::VectorXd difference =
              (45.0 * (at(h) - at(-h)) - 9.0 * (at(2 * h) - at(-2 * h)) + (at(3 * h) - at(-3 * h))) / (60.0 * h);
          const Eigen::VectorXd unit = Eigen::VectorXd::Unit(size, j);
          Eigen::VectorXd& analytic = column[velocity ? 1 : 0];
          analytic.resize(size);
          linearisation.times(velocity ? zero.data() : unit.data(), velocity ? unit.data() : zero.data(),
                              analytic.data());
          error = std::max(error, (difference - analytic).cwiseAbs().maxCoeff());
          greatest = std::max(greatest, analytic.cwiseAbs().maxCoeff());
        }
        for (Eigen::Index r = 0; r < 3; ++r) {
          const Eigen::Index row = r * n + j % n;
          const double expected = (row == j ? 1.0 : 0.0) - 0.3 * column[1][row] - 0.7 * column[0][row];
          const double found = blocks[static_cast<std::size_t>(9 * (j % n) + 3 * r + j / n)];
          block_error = std::max(block_error, std::abs(found - expected));
        }
      }
      // h^6 times seventh derivatives of sheets that are nearly folded; rounding over h.
      CHECK(error < 1e-8 * greatest);
      CHECK(block_error < 1e-12 * greatest);
      // Single nodes have the same.
      for (std::uint32_t k = 0; k < n; ++k) {
        Vector3 force, acceleration;
        layers::NodeDerivatives derivatives{};
        REQUIRE(fixture.evaluator->evaluate_node(k, 0.0, fixture.nodes(), fixture.external, nullptr, force,
                                                 acceleration, &derivatives, nullptr, message) == SPRINGNET_OK);
        fixture.evaluate();
        CHECK((force - Vector3(fixture.f[0][k], fixture.f[1][k], fixture.f[2][k])).norm() < 1e-12 * greatest);
        for (std::size_t i = 0; i < 9; ++i) {
          const double unit = i % 4 == 0 ? 1.0 : 0.0;
          CHECK(std::abs(unit - 0.3 * derivatives.by_velocity[i] - 0.7 * derivatives.by_position[i] -
                         blocks[9 * k + i]) < 1e-12 * greatest);
        }
      }
    }
  }
}

TEST_CASE("every update rule settles at the same step") {
  for (const Case& one : cases()) {
    CAPTURE(one.name);
    const Network net = net_of(one, 0.15, 3);
    std::vector<Vector3> expected;
    for (const double rule : {newton, synchronous, wavefront, block, coloured, automatic}) {
      CAPTURE(rule);
      Simulation simulation = simulate(net, recurrent(rule, 1e-10), 0.02);
      for (int i = 0; i < 3; ++i) REQUIRE(simulation.step().outcome == Outcome::settled);
      if (expected.empty()) expected = positions(simulation);
      // Steps whose forces are settled to some times 1e-10 N, of masses of 1 kg.
      CHECK(distance(expected, positions(simulation)) < 1e-9);
    }
  }
}

TEST_CASE("theta 1/2 approaches CVODE by the second order, theta 1 by the first") {
  for (const Case& one : cases()) {
    CAPTURE(one.name);
    const Network net = net_of(one, 0.1, 4);
    constexpr double until = 0.2;
    Simulation reference = simulate(net, cvode(1e-11), 0.05);
    reference.advance_to(until);
    const auto error = [&](double theta, double step) {
      Simulation simulation = simulate(net, recurrent(newton, 1e-12, {{"theta", theta}}), step);
      simulation.advance_to(until);
      return distance(positions(simulation), positions(reference));
    };
    CHECK(error(0.5, 0.01) / error(0.5, 0.005) == doctest::Approx(4.0).epsilon(0.1));
    CHECK(error(1.0, 0.002) / error(1.0, 0.001) == doctest::Approx(2.0).epsilon(0.1));
  }
}
