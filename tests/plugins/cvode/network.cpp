// cvode on networks: agreement of methods and linear solvers, closed forms, the analytic Jacobian.
#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "scenes.hpp"

namespace {
using namespace cvode_test;

TEST_CASE("undamped and damped oscillators, with an error in proportion to the tolerance") {
  const double mass = 2.0, stiffness = 50.0, stretch = 0.2, t = 2.0;
  for (const double damping : {0.0, 1.5}) {
    // x = a e^(-r t) (cos w t + r/w sin w t)
    const double r = damping / (2 * mass), w = std::sqrt(stiffness / mass - r * r);
    const double exact = stretch * std::exp(-r * t) * (std::cos(w * t) + r / w * std::sin(w * t));
    double previous = std::numeric_limits<double>::infinity();
    for (const double tolerance : {1e-5, 1e-7, 1e-9}) {
      CAPTURE(damping);
      CAPTURE(tolerance);
      Simulation simulation = simulate(oscillator(linear(stiffness, damping), mass, stretch), options(tolerance, t));
      simulation.step();
      const double error = std::abs(simulation.position(1)[0] - 1.0 - exact);
      CHECK(error < 300 * tolerance);  // errors of some hundred steps add up
      CHECK(error < previous / 5);     // the tolerance falls by 100; a fifth leaves room for luck in one component
      previous = error;
    }
    CHECK(previous > 0.0);
  }
}

TEST_CASE("tolerances of positions and of velocities have the same effect on steps") {
  // At 1 rad/s a position in m and a velocity in m/s go through the same numbers, so that the same tolerance of either,
  // the other being irrelevant, needs the same steps.
  const auto steps = [](double position, double velocity) {
    SimulationOptions each = options(1e-14, 50.0);
    each.integrator.parameters["position_tolerance"] = position;
    each.integrator.parameters["velocity_tolerance"] = velocity;
    Simulation simulation = simulate(oscillator(linear(2.0, 0.0), 2.0, 0.2), each);
    simulation.step();
    return simulation.statistics().at("internal_steps");
  };
  const double by_position = steps(1e-8, 1e3), by_velocity = steps(1e3, 1e-8);
  // Ten times the tolerance makes steps longer by a half at least, by 10^(1/6) at order 5, the highest.
  CHECK(by_position < 1.2 * by_velocity);
  CHECK(by_velocity < 1.2 * by_position);
  CHECK(steps(1e-7, 1e3) < 0.8 * by_position);
}

TEST_CASE("a network behaves the same with every method and linear solver") {
  const Network network = falling_lattice(3, 200.0, 2.0);
  const double tolerance = 1e-8;
  Eigen::MatrixXd reference;
  for (const auto& choice : {std::pair{bdf, direct}, {bdf, krylov}, {bdf, none}, {adams, none}, {adams, direct}}) {
    const Method method = choice.first;
    const Solver solver = choice.second;
    CAPTURE(method);
    CAPTURE(solver);
    Simulation simulation = simulate(network, options(tolerance, 0.25, method, solver));
    simulation.advance_to(1.5);
    const Eigen::MatrixXd positions = simulation.positions();
    if (reference.size() == 0) reference = positions;
    // The tolerance is for one step; several hundred steps and the sensitivity of the times of nine contacts add up.
    CHECK((positions - reference).cwiseAbs().maxCoeff() < 3000 * tolerance);
    CHECK(simulation.held(0));
  }
}

TEST_CASE("with the analytic Jacobian a stiff network needs few iterations a step") {
  // Springs of 1e8 N/m, damped, on nodes of 1 kg: explicit steps would have to be below 1e-4 s.
  Network network;
  Lattice lattice;
  lattice.nodes = {4, 4, 4};
  lattice.diagonals = Diagonals::space;
  network.add_lattice("block", lattice, node(Vector3::Zero()), network.add_material(linear(1e8, 1e5)));
  for (NodeIndex k = 0; k < 16; ++k) network.fix(k);
  network.set_gravity({3, 0, -10});
  for (const Solver solver : {direct, krylov}) {
    CAPTURE(solver);
    Simulation simulation = simulate(network, options(1e-6, 1.0, bdf, solver));
    simulation.advance_to(1.0);
    const auto& numbers = simulation.statistics();
    const double steps = numbers.at("internal_steps");
    CHECK(steps < 1000);
    CHECK(numbers.at("nonlinear_iterations") < 2 * steps);
    CHECK(numbers.at("convergence_failures") < 0.02 * steps + 1);
    CHECK(numbers.at("linearisations") < 0.5 * steps);  // derivatives are reused between steps
  }
}

TEST_CASE("a node in a viscous medium falls at the speed of the closed form") {
  // v = m g / b (1 - e^(-b t / m))
  const double mass = 0.5, drag = 2.0, g = 9.81;
  for (const Solver solver : {direct, krylov}) {
    Network network;
    Node falling = node({0, 0, 10}, mass);
    falling.neuron = network.add_neuron({"dragged", {{"drag", drag}}});
    network.add_node(falling);
    network.set_gravity({0, 0, -g});
    Simulation simulation = simulate(network, options(1e-9, 0.1, bdf, solver));
    simulation.advance_to(1.0);
    const double rate = drag / mass;
    const double speed = g / rate * (1 - std::exp(-rate));
    // tolerance x some hundred steps
    CHECK(simulation.velocity(0)[2] == doctest::Approx(-speed).epsilon(1e-7));
    CHECK(simulation.position(0)[2] ==
          doctest::Approx(10 - g / rate * (1 - (1 - std::exp(-rate)) / rate)).epsilon(1e-7));
    CHECK(simulation.statistics().at("convergence_failures") == 0);
  }
}

TEST_CASE("the result does not depend on where the origin is") {
  const auto run = [](double shift) {
    Network network;
    const NodeIndex a = network.add_node(node({shift, 0, 0}));
    const NodeIndex b = network.add_node(node({shift + 1.5, 0, 0}, 1.0, {0, 1, 0}));
    network.add_spring(a, b, network.add_material(linear(40.0)), 1.0);
    Simulation simulation = simulate(network, options(1e-6, 1.0));
    simulation.advance_to(2.0);
    return std::pair(Vector3(simulation.position(1) - simulation.position(0)),
                     simulation.statistics().at("internal_steps"));
  };
  const auto [near, near_steps] = run(0.0);
  const auto [far, far_steps] = run(4096.0);
  CHECK(near_steps == far_steps);
  // 4096 m has roundings of 1e-12 m; the motion multiplies them by less than a thousand in two seconds.
  CHECK((near - far).norm() < 1e-9);
}

TEST_CASE("steps do not depend on the time step of the output") {
  const auto run = [](double time_step) {
    Simulation simulation = simulate(oscillator(linear(50.0, 0.5), 2.0, 0.2), options(1e-7, time_step));
    simulation.advance_to(2.0);
    return std::pair(simulation.position(1)[0], simulation.statistics().at("internal_steps"));
  };
  CHECK(run(2.0) == run(0.001953125));
}

TEST_CASE("threads do not change a bit") {
  const auto run = [](unsigned threads) {
    SimulationOptions with = options(1e-7, 0.5);
    with.threads = threads;
    Simulation simulation = simulate(falling_lattice(4, 100.0, 1.0), with);
    simulation.advance_to(1.0);
    return Eigen::MatrixXd(simulation.positions());
  };
  CHECK(run(1) == run(2));
}

TEST_CASE("too many steps end in an error with the remedy, and leave the network unchanged") {
  SimulationOptions few = options(1e-9, 10.0);
  few.integrator.parameters["max_steps"] = 50;
  Simulation simulation = simulate(oscillator(linear(1e4), 1.0, 0.2), few);
  try {
    simulation.step();
    FAIL("50 steps are not enough");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::simulation);
    const std::string text = error.what();
    CAPTURE(text);
    CHECK(text.find("50 internal steps") != std::string::npos);
    CHECK(text.find("max_steps") != std::string::npos);
  }
  CHECK(simulation.time() == 0.0);
  CHECK(simulation.position(1)[0] == 1.2);
}

TEST_CASE("options that do not fit together are refused at the start") {
  SimulationOptions wrong = options(1e-9, 1.0);
  wrong.integrator.parameters["max_order"] = 12;
  CHECK_THROWS_WITH_AS(simulate(oscillator(linear(1), 1.0, 0.2), wrong), doctest::Contains("max_order"), Error);
}

}  // namespace
