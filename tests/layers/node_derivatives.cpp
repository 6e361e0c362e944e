// A single node: its derivatives against those of the whole net, its energy against its force.
#include <cmath>
#include <numeric>

#include <doctest/doctest.h>

#include <Eigen/Dense>

#include "layers/linear/linearisation.hpp"
#include "random_net.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("a node's own derivatives are the diagonal blocks of the whole net's") {
  const Network net = random_network(25, 4, 21);
  EvaluatorFixture fixture(net);
  const std::uint32_t n = fixture.layout.node_count();
  const std::vector<std::uint8_t> constrained(n, 0);
  layers::Linearisation linearisation(fixture.layout, *fixture.evaluator, constrained);
  springnet_message message{};
  REQUIRE(linearisation.update(0.0, fixture.nodes(), fixture.external, message) == SPRINGNET_OK);
  std::vector<double> by_velocity(9 * std::size_t{n}), by_position(9 * std::size_t{n});
  linearisation.diagonal_blocks(1.0, 0.0, by_velocity.data());
  linearisation.diagonal_blocks(0.0, 1.0, by_position.data());
  for (std::uint32_t k = 0; k < n; ++k) {
    Vector3 plain, force, acceleration;
    layers::NodeDerivatives derivatives{};
    REQUIRE(fixture.evaluator->evaluate_node(k, 0.0, fixture.nodes(), fixture.external, nullptr, plain, message) ==
            SPRINGNET_OK);
    REQUIRE(fixture.evaluator->evaluate_node(k, 0.0, fixture.nodes(), fixture.external, nullptr, force, acceleration,
                                             &derivatives, nullptr, message) == SPRINGNET_OK);
    CHECK(force == plain);
    for (std::size_t i = 0; i < 9; ++i) {
      const double one = i % 4 == 0 ? 1.0 : 0.0;
      // The same sums in the same order, I - (.) aside: rounding of entries of order 100.
      CHECK(std::abs(one - derivatives.by_velocity[i] - by_velocity[9 * k + i]) < 1e-12);
      CHECK(std::abs(one - derivatives.by_position[i] - by_position[9 * k + i]) < 1e-12);
    }
  }
}

TEST_CASE("a node's energy falls by the work of its force, and is nan where there is no potential") {
  const auto net = [](std::optional<LawUse> viscosity, const char* neuron) {
    Network result;
    const MaterialIndex soft =
        result.add_material({LawUse{"nonlinear", {{"stiffness", 3.0}, {"cubic", 2.0}}}, std::nullopt});
    const MaterialIndex other = result.add_material({LawUse{"linear", {{"stiffness", 7.0}}}, std::move(viscosity)});
    for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0.2, 0), Vector3(-0.3, 1.1, 0.4), Vector3(0.1, 0.2, 1)}) {
      Node node;
      node.position = p;
      node.mass = 1.7;
      if (std::string(neuron) != "point_mass") node.neuron = result.add_neuron({neuron, {{"drag", 0.5}}});
      result.add_node(node);
    }
    for (NodeIndex k = 1; k < 4; ++k) result.add_spring(0, k, k == 2 ? other : soft, 0.8);
    result.add_load({{0}, {0.3, -0.2, 0.1}});
    result.set_gravity({0, 0, -2});
    return result;
  };
  EvaluatorFixture fixture(net(std::nullopt, "point_mass"));
  fixture.external.gravity = {0, 0, -2};
  std::vector<double> load{0.3, -0.2, 0.1};
  std::vector<double> loads[3];
  const std::uint32_t node = fixture.layout.ordering().engine[0];
  for (std::size_t c = 0; c < 3; ++c) {
    loads[c].assign(4, 0.0);
    loads[c][node] = load[c];
  }
  fixture.external.loads = {loads[0].data(), loads[1].data(), loads[2].data()};
  springnet_message message{};
  Vector3 force, acceleration;
  const auto energy = [&] {
    double value = 0.0;
    REQUIRE(fixture.evaluator->evaluate_node(node, 0.0, fixture.nodes(), fixture.external, nullptr, force, acceleration,
                                             nullptr, &value, message) == SPRINGNET_OK);
    return value;
  };
  constexpr double h = 1e-4;
  static_cast<void>(energy());
  const Vector3 expected = force;
  CHECK((acceleration - force / 1.7).norm() < 1e-15);  // rounding
  for (std::size_t c = 0; c < 3; ++c) {
    double& coordinate = fixture.p[c][node];
    const double value = coordinate;
    coordinate = value + h;
    const double up = energy();
    coordinate = value - h;
    const double down = energy();
    coordinate = value;
    // Central difference: h^2 times third derivatives of some tens.
    CHECK(-(up - down) / (2 * h) == doctest::Approx(expected[static_cast<Eigen::Index>(c)]).epsilon(1e-6));
  }

  for (const bool viscous : {true, false}) {
    CAPTURE(viscous);
    EvaluatorFixture without(net(viscous ? std::optional(LawUse{"linear", {{"damping", 0.1}}}) : std::nullopt,
                                 viscous ? "point_mass" : "dragged"));
    double value = 0.0;
    REQUIRE(without.evaluator->evaluate_node(without.layout.ordering().engine[0], 0.0, without.nodes(),
                                             without.external, nullptr, force, acceleration, nullptr, &value,
                                             message) == SPRINGNET_OK);
    CHECK(std::isnan(value));
  }
}
