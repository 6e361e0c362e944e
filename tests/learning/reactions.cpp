// Forces that hold nodes: those of a run, their derivatives, and the scale of masses and stiffnesses that they tell.

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/reaction_derivatives.hpp>

#include "learning_nets.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// A chain between a fixed node and one that is moved, with a load that rises and ends on all of its nodes.
Network held_chain() {
  Node prototype;
  prototype.mass = 0.8;
  Network net;
  prototype.neuron = net.add_neuron({"dragged", {{"drag", 0.3}}});
  const MaterialIndex material = net.add_material(damped(40.0, 1.5));
  for (int k = 0; k < 5; ++k) {
    prototype.position = {1.0 * k, 0.2 * k * k, 0.1 * k};
    prototype.velocity = {0.3, -0.2 * k, 0.1};
    net.add_node(prototype);
  }
  for (NodeIndex k = 0; k < 4; ++k) net.add_spring(k, k + 1, material, 1.0);
  net.add_element(Invariant::angle, {0, 1, 2}, net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, {}}), 2.0);
  net.fix(0);
  Move move;
  move.nodes = {4};
  move.motion.amplitude = {0.1, 0.2, 0};
  move.motion.frequency = 0.7;
  net.add_move(move);
  Load load;
  load.nodes = {0, 1, 2, 3, 4};
  load.force = {0.5, 1.0, -0.7};
  load.from = 0.055;
  load.until = 0.145;
  load.course.ramp = 0.05;
  net.add_load(load);
  net.set_gravity({0, 0, -9.81});
  return net;
}

std::vector<LearnedValues> of_all(const Network& net) {
  const std::vector<std::uint32_t> nodes = from_to(0, net.nodes().size()), springs = from_to(0, net.springs().size());
  return {{Kind::spring_parameter, false, "stiffness", springs},
          {Kind::viscosity_parameter, false, "damping", springs},
          {Kind::rest_length, false, "", springs},
          {Kind::spring_parameter, true, "stiffness", {0}},
          {Kind::mass, false, "", nodes},
          {Kind::neuron_parameter, false, "drag", nodes},
          {Kind::initial_velocity, false, "", {1, 2, 3}},
          {Kind::load, false, "", {0}},
          {Kind::gravity, false, "", {0, 1, 2}}};
}

}  // namespace

TEST_CASE("reactions at states are those of a run, for every theta") {
  const auto net = std::make_shared<const Network>(held_chain());
  for (const double theta : {1.0, 0.5, 0.7}) {
    CAPTURE(theta);
    const SimulationOptions options = to_learn_with(theta, 0.02);
    MotionDerivatives motion(net, plugins(), options, 0.2, of_all(*net));
    ReactionDerivatives reactions(net, plugins(), options, of_all(*net));
    VectorXd values = motion.values_of_network();
    values[1] = 55.0;  // a stiffness
    motion.run(values);
    reactions.set_values(values);
    Simulation simulation(net, plugins(), options);
    simulation.set_parameter({1}, ComponentKind::spring_function, "stiffness", {55.0});
    for (std::size_t state = 1; state <= motion.step_count(); ++state) {
      simulation.step();
      const Matrix3Xd own = reactions.at(motion, state);
      for (NodeIndex k = 0; k < 5; ++k) {
        CAPTURE(state);
        CAPTURE(k);
        CHECK((own.col(k) - simulation.reaction(k)).norm() < 1e-12 * (1.0 + simulation.reaction(k).norm()));
      }
      CHECK(own.col(0).norm() > 1.0);
      CHECK(own.col(2).norm() == 0.0);
    }
  }
}

TEST_CASE("reactions of held nodes while others slide on a floor, and their derivatives") {
  Network given = held_chain();
  Plane floor;
  floor.name = "floor";
  floor.point = {0, 0, 0.05};
  floor.friction = {Friction::Kind::coulomb, 0.2};
  given.add_plane(floor);
  const auto net = std::make_shared<const Network>(given);
  const SimulationOptions options = to_learn_with(0.7, 0.02);
  MotionDerivatives motion(net, plugins(), options, 0.2, of_all(*net));
  ReactionDerivatives reactions(net, plugins(), options, of_all(*net));
  const VectorXd values = motion.values_of_network();
  Simulation simulation(net, plugins(), options);
  simulation.advance_to(0.2);
  REQUIRE(simulation.touching(1));
  const auto loss = [&](const VectorXd& at) {
    motion.run(at);
    reactions.set_values(at);
    return reactions.at(motion, motion.step_count()).sum();
  };
  static_cast<void>(loss(values));
  for (const NodeIndex k : {0U, 4U})
    CHECK((reactions.at(motion, motion.step_count()).col(k) - simulation.reaction(k)).norm() <
          1e-12 * simulation.reaction(k).norm());
  VectorXd directly = VectorXd::Zero(values.size());
  const VectorXd gradient = motion.adjoint([&](std::size_t state, MotionDerivatives::StateChange& to) {
    if (state == motion.step_count()) reactions.add_adjoint(motion, state, Matrix3Xd::Ones(3, 5), to, directly);
  }) + directly;
  Dice dice(8);
  VectorXd change(values.size());
  for (Eigen::Index k = 0; k < change.size(); ++k) change[k] = dice.between(-1, 1) * std::max(0.1, std::abs(values[k]));
  const double h = 1e-5, difference = (8.0 * (loss(values + h * change) - loss(values - h * change)) -
                                       (loss(values + 2 * h * change) - loss(values - 2 * h * change))) /
                                      (12.0 * h);
  CHECK(gradient.dot(change) == doctest::Approx(difference).epsilon(1e-6));
}

TEST_CASE("derivatives of reactions are those of differences") {
  const auto net = std::make_shared<const Network>(held_chain());
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  MotionDerivatives motion(net, plugins(), options, 0.2, of_all(*net));
  ReactionDerivatives reactions(net, plugins(), options, of_all(*net));
  const VectorXd values = motion.values_of_network();
  Dice dice(4);
  Matrix3Xd weights(3, 5);
  for (double& each : weights.reshaped()) each = dice.between(-1, 1);
  // Of all states, with weights that change from one to the next.
  const auto loss = [&](const VectorXd& at) {
    motion.run(at);
    reactions.set_values(at);
    double sum = 0.0;
    for (std::size_t k = 0; k <= motion.step_count(); ++k)
      sum += std::cos(static_cast<double>(k)) * weights.cwiseProduct(reactions.at(motion, k)).sum();
    return sum;
  };
  static_cast<void>(loss(values));
  VectorXd direct = VectorXd::Zero(values.size());
  VectorXd gradient = motion.adjoint([&](std::size_t k, MotionDerivatives::StateChange& add) {
    reactions.add_adjoint(motion, k, std::cos(static_cast<double>(k)) * weights, add, direct);
  });
  CHECK(direct.norm() > 1.0);
  gradient += direct;
  MatrixXd changes(values.size(), values.size());
  for (Eigen::Index i = 0; i < changes.size(); ++i) changes.data()[i] = dice.between(-1, 1);
  VectorXd along = VectorXd::Zero(changes.cols());
  motion.tangent(changes, [&](std::size_t k, const MatrixXd& positions, const MatrixXd& velocities) {
    along += std::cos(static_cast<double>(k)) *
             (reactions.tangent(motion, k, changes, positions, velocities).transpose() * weights.reshaped());
  });
  CHECK((changes.transpose() * gradient - along).norm() < 1e-9 * along.norm());
  for (Eigen::Index j = 0; j < values.size(); ++j) {
    CAPTURE(j);
    constexpr double h = 1e-3;
    const auto at = [&](double by) { return loss(values + by * VectorXd::Unit(values.size(), j)); };
    const double difference =
        (45.0 * (at(h) - at(-h)) - 9.0 * (at(2 * h) - at(-2 * h)) + at(3 * h) - at(-3 * h)) / (60.0 * h);
    CHECK(std::abs(gradient[j] - difference) < 1e-7 * (1.0 + std::abs(difference)));
  }
}

TEST_CASE("reactions tell the scale of masses, stiffnesses and dampings that no motion tells") {
  Network real = chain(5, {0, 0, 0}, {1, 0.1, 0}, damped(20.0, 0.5));
  real.fix(0);
  for (NodeIndex k = 1; k < 5; ++k) {
    Node node = real.nodes()[k];
    node.velocity = {0.1 * k, 0.2 - 0.1 * k, 0.05 * k * k};
    real.set_node(k, node);
  }
  const SimulationOptions options = to_learn_with(0.5, 0.05);
  // All masses, stiffnesses and dampings 1.5 times the true ones: the same motion.
  Simulation scaled(real, plugins(), options);
  scaled.set_parameter(from_to(0, 4), ComponentKind::spring_function, "stiffness", {30.0});
  scaled.set_parameter(from_to(0, 4), ComponentKind::viscosity_function, "damping", {0.75});
  scaled.set_masses(from_to(1, 5), {1.5});
  const Network guess = scaled.present_network();
  Simulation simulation(real, plugins(), options);
  Observations motion, with_forces;
  for (int i = 0; i < 30; ++i) {
    simulation.step();
    for (NodeIndex k = 1; k < 5; ++k) motion.positions.push_back(row(simulation.time(), k, simulation.position(k)));
    with_forces.reactions.push_back(row(simulation.time(), 0, simulation.reaction(0)));
  }
  with_forces.append(motion);
  const std::vector<Learnable> all{{{Kind::spring_parameter, false, "stiffness", from_to(0, 4)}},
                                   {{Kind::viscosity_parameter, false, "damping", from_to(0, 4)}},
                                   {{Kind::mass, false, "", from_to(1, 5)}}};
  const LearnedNet by_motion = learn({experiment(guess, options, motion)}, plugins(), all);
  CHECK(by_motion.undetermined == 1);
  CHECK(by_motion.start_cost < 1e-18);
  const LearnedNet by_forces = learn({experiment(guess, options, with_forces)}, plugins(), all);
  CAPTURE(by_forces.reason);
  CHECK(by_forces.undetermined == 0);
  CHECK(by_forces.start_cost > 1.0);
  for (const LearnedParameter& each : by_forces.parameters)
    CHECK(each.value == doctest::Approx(each.start / 1.5).epsilon(1e-6));
  // The paper's method learns from them, too.
  const LearnedNet online = learn_online(experiment(guess, options, with_forces), plugins(), all);
  CHECK(online.cost < online.start_cost);
}

TEST_CASE("reactions of a node that nothing holds are refused with their place") {
  const Network net = held_chain();
  Observations seen;
  seen.files.push_back({"forces.csv", false});
  seen.reactions.push_back(row(0.1, 2, {1, 0, 0}));
  seen.reactions.back().place = {0, 7};
  const std::string told = refusal_of([&] {
    static_cast<void>(learn({experiment(net, to_learn_with(0.5, 0.02), seen)}, plugins(),
                            {{{Kind::spring_parameter, false, "stiffness", {0}}}}));
  });
  CHECK(told.find("forces.csv:7: node 2 is neither fixed nor moved") != std::string::npos);
}
