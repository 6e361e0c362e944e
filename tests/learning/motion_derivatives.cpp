// Derivatives of trajectories: the adjoint against the tangent, and both against differences of the motion itself.

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/motion_derivatives.hpp>

#include "generator.hpp"
#include "motion_loss.hpp"
#include "nets.hpp"
#include "uneven.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// Springs and dampers of two laws, muscles, angles, areas, a volume; a load that comes and goes, a fixed and a moved
// node.
Network varied() {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 2};
  lattice.diagonals = Diagonals::face;
  Node node;
  node.neuron = net.add_neuron({"dragged", {{"drag", 0.1}}});
  net.add_lattice("block", lattice, node, net.add_material(damped(60.0, 1.0)));
  make_uneven(net, 5, 0.05, 0.5, [](const Vector3&) { return Vector3(0, 0, 0); });
  net.fix(0);
  const MaterialIndex cubic = net.add_material(
      {LawUse{"nonlinear", {{"stiffness", 20.0}, {"cubic", 40.0}}}, LawUse{"linear", {{"damping", 0.7}}}});
  net.add_spring(3, net.add_node(point({0, 1, 3}, 0.7)), cubic);
  const MaterialIndex bending =
      net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, LawUse{"linear", {{"damping", 0.2}}}});
  net.add_element(Invariant::angle, {0, 1, 2}, bending, 2.6);
  net.add_element(Invariant::area, {3, 4, 7}, bending, 0.6);
  net.add_element(Invariant::volume, {3, 4, 7, 12}, bending, 0.2);
  Move move;
  move.nodes = {2};
  move.motion.times = {0.0, 0.3};
  move.motion.displacements = {{0, 0, 0}, {0.2, 0, 0.1}};
  net.add_move(move);
  Load load;
  load.nodes = {10, 11};
  load.force = {2.0, 0, 1.0};
  load.from = 0.03;
  load.until = 0.17;
  net.add_load(load);
  net.set_gravity({0, 0, -3.0});
  return net;
}

std::vector<LearnedValues> everything(const Network& net) {
  const std::size_t springs = net.springs().size(), elements = net.elements().size(), nodes = net.nodes().size();
  std::vector<std::uint32_t> moving = all(nodes);
  std::erase_if(moving, [](std::uint32_t k) { return k == 0 || k == 2; });
  return {{Kind::spring_parameter, false, "stiffness", all(springs)},
          {Kind::spring_parameter, false, "cubic", {static_cast<SpringIndex>(springs - 1)}},
          {Kind::viscosity_parameter, false, "damping", all(springs)},
          {Kind::rest_length, false, "", all(springs)},
          {Kind::spring_parameter, true, "stiffness", all(elements)},
          {Kind::viscosity_parameter, true, "damping", all(elements)},
          {Kind::rest_length, true, "", all(elements)},
          {Kind::mass, false, "", moving},
          {Kind::neuron_parameter, false, "drag", all(nodes - 1)},
          {Kind::initial_velocity, false, "", moving},
          {Kind::gravity, false, "", {0, 1, 2}}};
}

}  // namespace

TEST_CASE("the gradient of a motion is that of differences of the motion, for every rule, theta and kind of value") {
  const auto net = std::make_shared<const Network>(varied());
  for (const double theta : {1.0, 0.5, 0.7})
    for (const double rule : {newton, block, wavefront}) {
      CAPTURE(theta);
      CAPTURE(rule);
      MotionDerivatives motion(net, plugins(), method(theta, rule), 0.3, everything(*net));
      const VectorXd values = motion.values_of_network();
      motion.run(values);
      REQUIRE(motion.step_count() == 15);
      const Loss loss(16, net->nodes().size());
      const VectorXd gradient = loss.gradient(motion);
      // Along directions at random, each value by its size.
      Dice dice(3);
      Eigen::MatrixXd changes(values.size(), 3);
      for (Eigen::Index i = 0; i < changes.size(); ++i)
        changes.data()[i] = dice.between(-1, 1) * std::max(0.1, std::abs(values[i % values.size()]));
      const VectorXd along = loss.along(motion, changes);
      for (Eigen::Index j = 0; j < 3; ++j) {
        CHECK(gradient.dot(changes.col(j)) == doctest::Approx(along[j]).epsilon(1e-9));  // systems are solved to 1e-11
        const auto at = [&](double h) {
          motion.run(values + h * changes.col(j));
          return loss.of(motion);
        };
        // Of sixth order; rounding and the tolerance of the steps, 1e-12 N, over h.
        constexpr double h = 2e-3;
        const double difference =
            (45.0 * (at(h) - at(-h)) - 9.0 * (at(2 * h) - at(-2 * h)) + at(3 * h) - at(-3 * h)) / (60.0 * h);
        CHECK(along[j] == doctest::Approx(difference).epsilon(1e-7));
      }
    }
}

TEST_CASE("each value's derivative by itself") {
  const auto net = std::make_shared<const Network>(varied());
  MotionDerivatives motion(net, plugins(), method(0.5, newton), 0.2, everything(*net));
  const VectorXd values = motion.values_of_network();
  motion.run(values);
  const Loss loss(11, net->nodes().size());
  const VectorXd gradient = loss.gradient(motion);
  double greatest = 0.0;
  for (Eigen::Index j = 0; j < values.size(); ++j) {
    const double h = 1e-3 * std::max(0.1, std::abs(values[j]));
    const auto at = [&](double by) {
      VectorXd own = values;
      own[j] += by;
      motion.run(own);
      return loss.of(motion);
    };
    const double difference = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
    const double scale = std::max(0.1, std::abs(values[j]));
    greatest = std::max(greatest, std::abs(gradient[j] - difference) * scale);
  }
  CHECK(greatest < 1e-7 * (1.0 + std::abs(loss.of(motion))));
}

TEST_CASE("the derivative of a free flight is known in closed form") {
  Network net;
  net.add_node(point({0, 0, 0}, 2.0, {1, 2, 3}));
  Load load;
  load.nodes = {0};
  load.force = {0, 0, 4.0};
  net.add_load(load);
  MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), method(0.5, newton, 0.1), 1.0,
                           {{Kind::mass, false, "", {0}}, {Kind::initial_velocity, false, "", {0}}});
  motion.run(motion.values_of_network());
  CHECK(motion.positions(10)(2, 0) == doctest::Approx(4.0).epsilon(1e-12));
  const VectorXd gradient = motion.adjoint([](std::size_t k, MotionDerivatives::StateChange& add) {
    if (k == 10) add.positions(2, 0) = 1.0;
  });
  CHECK(gradient[0] == doctest::Approx(-0.5).epsilon(1e-12));  // of v t + F t^2 / (2 m)
  CHECK(gradient[1] == 0.0);
  CHECK(gradient[3] == doctest::Approx(1.0).epsilon(1e-12));
}

TEST_CASE("what is not differentiated is refused with what it is") {
  const Network net = varied();
  const auto refused = [](const Network& of, const SimulationOptions& options, std::vector<LearnedValues> learned,
                          const std::string& message, double duration = 0.1) {
    std::string said;
    try {
      MotionDerivatives motion(std::make_shared<const Network>(of), plugins(), options, duration, std::move(learned));
      motion.run(motion.values_of_network());
    } catch (const Error& error) {
      said = error.what();
    }
    CAPTURE(said);
    CHECK(said.find(message) != std::string::npos);
  };
  const LearnedValues mass{Kind::mass, false, "", {1}};
  SimulationOptions other = method(1.0, newton);
  other.integrator = cvode(1e-6);
  refused(net, other, {mass}, "only steps of 'recurrent'");
  other.integrator = single_sweep();
  refused(net, other, {mass}, "set sweeps = 0");
  refused(net, method(1.0, newton), {}, "nothing to be learned");
  refused(net, method(1.0, newton), {{Kind::mass, false, "", {}}}, "nothing to be learned");
  refused(net, method(1.0, newton), {mass, {Kind::mass, false, "", {4, 1}}}, "node 1 is listed twice");
  refused(net, method(1.0, newton), {mass}, "no time step", 0.001);
  refused(net, method(1.0, newton), {{Kind::mass, false, "", {100}}}, "node 100 does not exist");
  refused(net, method(1.0, newton), {{Kind::mass, false, "", {1, 1}}}, "node 1 is listed twice");
  refused(net, method(1.0, newton), {{Kind::initial_velocity, false, "", {0}}}, "node 0 is fixed");
  refused(net, method(1.0, newton), {{Kind::spring_parameter, false, "stifness", {0}}}, "stiffness");
}

// The bending of an angle follows the velocities of its nodes where it is exactly straight: its law has the derivative
// that steps are linearised with where it is at rest, and others are refused only where it matters.
TEST_CASE("an angle that is exactly straight at the start") {
  const auto chain = [](double reference) {
    Network net;
    const MaterialIndex material = net.add_material(damped(60.0, 1.0));
    for (int k = 0; k < 3; ++k) net.add_node(point({1.1 * k, 0, 0}, 0.5 + 0.2 * k));
    for (NodeIndex k = 1; k < 3; ++k) {
      Node own = net.nodes()[k];
      own.velocity = {0.1, 0.3 * k - 0.4, 0.2 * k};
      net.set_node(k, own);
      net.add_spring(k - 1, k, material);
    }
    net.fix(0);
    net.add_element(Invariant::angle, {0, 1, 2},
                    net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, LawUse{"linear", {{"damping", 0.2}}}}),
                    reference);
    return std::make_shared<const Network>(net);
  };
  const LearnedValues velocities{Kind::initial_velocity, false, "", {1, 2}};
  const LearnedValues laws{Kind::spring_parameter, true, "stiffness", {0}};
  const auto check = [&](double reference, double theta, const LearnedValues& learned) {
    CAPTURE(reference);
    CAPTURE(theta);
    MotionDerivatives motion(chain(reference), plugins(), method(theta, newton), 0.2, {learned});
    const VectorXd values = motion.values_of_network();
    motion.run(values);
    const Loss loss(motion.step_count() + 1, 3);
    const VectorXd gradient = loss.gradient(motion);
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const auto at = [&](double change) {
        VectorXd changed = values;
        changed[i] += change;
        motion.run(changed);
        return loss.of(motion);
      };
      constexpr double h = 1e-4;
      const double difference = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
      CHECK(gradient[i] == doctest::Approx(difference).epsilon(1e-6));
    }
  };
  const double pi = std::acos(-1.0);
  check(pi, 0.5, velocities);
  check(pi, 1.0, velocities);
  check(2.6, 1.0, velocities);
  check(2.6, 0.5, laws);
  std::string said;
  try {
    check(2.6, 0.5, velocities);
  } catch (const Error& error) {
    said = error.what();
  }
  CHECK(said.find("element 0, an angle, is exactly straight at the start") != std::string::npos);
}
