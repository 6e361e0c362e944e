// The theta method of second order, and the acceleration that steps start from.
#include <cmath>
#include <string>

#include <doctest/doctest.h>

#include <Eigen/Dense>

#include "nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

using State = Eigen::Vector2d;  // elongation m, velocity m/s

// x' = v, m v' = -k x - d v + F: one step of the theta method, solved exactly.
State theta_step(const State& y, double k, double d, double m, double force, double h, double theta) {
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -k / m, -d / m;
  const State b(0.0, force / m);
  const Eigen::Matrix2d one = Eigen::Matrix2d::Identity();
  const State right_side = (one + (1.0 - theta) * h * a) * y + h * b;
  return (one - theta * h * a).inverse() * right_side;
}

State state_of(const Simulation& simulation) { return {simulation.position(1)[0] - 1.0, simulation.velocity(1)[0]}; }

constexpr double all_rules[] = {synchronous, wavefront, block, coloured, newton, automatic};

}  // namespace

TEST_CASE("each rule's step is that of the theta method: under-, critically and over-damped") {
  constexpr double m = 1.3, k = 9.0, h = 0.05, force_tolerance = 1e-13;
  const double critical = 2.0 * std::sqrt(k * m);
  for (const double theta : {0.5, 0.7, 1.0}) {
    for (const double share : {0.0, 0.2, 1.0, 3.0}) {
      for (const double update : all_rules) {
        CAPTURE(theta);
        CAPTURE(share);
        CAPTURE(update);
        const double d = share * critical;
        Simulation simulation =
            simulate(oscillator(damped(k, d), m, 0.2, -0.4), recurrent(update, force_tolerance, {{"theta", theta}}), h);
        State expected(0.2, -0.4);
        for (int i = 0; i < 40; ++i) {
          CHECK(simulation.step().outcome == Outcome::settled);
          expected = theta_step(expected, k, d, m, 0.0, h, theta);
        }
        // What each step leaves, a few tolerances times h / m, and rounding; 40 steps of it.
        CHECK((state_of(simulation) - expected).norm() < 1e-12);
      }
    }
  }
}

TEST_CASE("theta 1/2 is of second order, and keeps the energy of an oscillator without damping") {
  constexpr double m = 1.0, k = 16.0, start = 0.1, end = 1.0;
  for (const double damping : {0.0, 1.0, 8.0, 20.0}) {
    CAPTURE(damping);
    // The exact solution, from the matrix exponential of a 2x2 system.
    const double decay = damping / (2.0 * m), square = k / m - decay * decay;
    const double omega = std::sqrt(std::abs(square));
    const double c = square > 0 ? std::cos(omega * end) : std::cosh(omega * end);
    const double s = omega < 1e-12 ? end : (square > 0 ? std::sin(omega * end) : std::sinh(omega * end)) / omega;
    const double exact = start * std::exp(-decay * end) * (c + decay * s);
    double last = 0.0;
    for (const double h : {0.02, 0.01, 0.005}) {
      Simulation simulation =
          simulate(oscillator(damped(k, damping), m, start), recurrent(newton, 1e-13, {{"theta", 0.5}}), h);
      simulation.advance_to(end);
      const double error = std::abs(state_of(simulation)[0] - exact);
      // What is left of the fourth order is of the size (h times the fastest rate)^2: at most 0.15.
      if (last > 0.0) CHECK(std::log2(last / error) == doctest::Approx(2.0).epsilon(0.05));
      last = error;
      if (damping == 0.0) {
        const State y = state_of(simulation);
        // The trapezoidal rule conserves quadratic energies; tolerance and rounding of 200 steps.
        CHECK(std::abs(0.5 * (m * y[1] * y[1] + k * y[0] * y[0]) - 0.5 * k * start * start) < 1e-12);
      }
    }
  }
}

TEST_CASE("a normal mode of a fixed-fixed chain with theta 1/2") {
  // Ten free nodes, longitudinal mode 3: x_j = sin(3 pi j / 11) cos(omega t), omega = 2 sqrt(k / m) sin(3 pi / 22).
  constexpr double m = 0.7, k = 20.0, amplitude = 0.01, end = 1.0;
  const double omega = 2.0 * std::sqrt(k / m) * std::sin(3.0 * M_PI / 22.0);
  for (const double update : {wavefront, newton}) {
    CAPTURE(update);
    double last = 0.0;
    for (const double h : {0.02, 0.01}) {
      Network net = chain(12, Vector3::Zero(), {1, 0, 0}, damped(k, 0.0), m);
      net.fix(0);
      net.fix(11);
      Simulation simulation = simulate(net, recurrent(update, 1e-12, {{"theta", 0.5}}), h);
      for (NodeIndex j = 1; j < 11; ++j)
        simulation.set_position(j, {j + amplitude * std::sin(3.0 * M_PI * j / 11.0), 0, 0});
      simulation.advance_to(end);
      const double error =
          std::abs(simulation.position(2)[0] - 2.0 - amplitude * std::sin(6.0 * M_PI / 11.0) * std::cos(omega * end));
      if (last > 0.0) CHECK(std::log2(last / error) == doctest::Approx(2.0).epsilon(0.02));  // (omega h)^2 / 10
      last = error;
    }
  }
}

TEST_CASE("the stored acceleration is evaluated anew after a cut, a switched load, a rupture, a set state") {
  // Two springs pull node 1 along x; one of them goes after ten steps, or a force comes. Each step is compared with the
  // theta method, in which the old activities weigh half: an acceleration from before the change would show at once.
  constexpr double m = 1.0, k = 10.0, h = 0.02, extra = 6.0;
  const auto net_with = [&](const std::string& change) {
    Network net = oscillator(damped(k, 0.5), m, 0.2);
    if (change == "cut" || change == "rupture") {
      Node far = point({3, 0, 0});
      far.fixed = true;
      net.add_node(far);
      // As long as it is, of no stiffness that matters to the motion: it pulls with 3 N and breaks by time.
      net.add_spring(1, 2, net.add_material(damped(extra, 0.0)), 1.0);
    }
    if (change == "cut") net.add_cut({10 * h, {1}, {}});
    if (change == "load") net.add_load({{1}, {-4, 0, 0}, 10 * h});
    return net;
  };
  for (const std::string change : {"cut", "load", "force", "velocity"}) {
    for (const double update : {synchronous, block, newton}) {
      CAPTURE(change);
      CAPTURE(update);
      Simulation simulation = simulate(net_with(change), recurrent(update, 1e-13, {{"theta", 0.5}}), h);
      State expected(0.2, 0.0);
      for (int i = 0; i < 20; ++i) {
        const bool after = i >= 10;
        double stiffness = k, force = 0.0;
        if (change == "cut" && !after) {
          // Its length is 2 - x: it pulls with extra (1 - x).
          stiffness += extra;
          force = extra;
        }
        if ((change == "load" || change == "force") && after) force = -4.0;
        if (change == "force" && i == 10) simulation.set_force(1, {-4, 0, 0});
        if (change == "velocity" && i == 10) {
          simulation.set_velocity(1, {-0.7, 0, 0});
          expected[1] = -0.7;
        }
        expected = theta_step(expected, stiffness, 0.5, m, force, h, 0.5);
        simulation.step();
        CHECK((state_of(simulation) - expected).norm() < 1e-12);  // tolerance and rounding of 20 steps
      }
    }
  }

  // A spring that breaks under its growing tension: found by the simulation, and from then on as if it had never been.
  Network net = oscillator(damped(k, 0.5), m, 0.2, 1.0);
  Node far = point({3, 0, 0});
  far.fixed = true;
  net.add_node(far);
  net.add_spring(0, 1, net.add_material({LawUse{"rupturing", {{"stiffness", extra}, {"strength", 1.6}}}, std::nullopt}),
                 1.0);
  Simulation simulation = simulate(net, recurrent(newton, 1e-13, {{"theta", 0.5}}), h);
  State expected(0.2, 1.0);
  bool was_alive = true;
  for (int i = 0; i < 20; ++i) {
    const bool alive = simulation.alive(1);
    expected = theta_step(expected, alive ? k + extra : k, 0.5, m, 0.0, h, 0.5);
    simulation.step();
    CHECK((state_of(simulation) - expected).norm() < 1e-12);
    was_alive = was_alive && simulation.alive(1);
  }
  CHECK_FALSE(was_alive);
}
