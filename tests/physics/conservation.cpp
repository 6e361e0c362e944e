// Conserved quantities, and how each method changes them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

// Two masses of 1 kg on one spring in circular motion about their centre, at `omega` 1/s and `distance` m.
Network rotating_pair(double omega, double distance, double rest_length) {
  Network net;
  const double speed = omega * distance / 2.0;
  net.add_node(point({distance / 2, 0, 0}, 1.0, {0, speed, 0}));
  net.add_node(point({-distance / 2, 0, 0}, 1.0, {0, -speed, 0}));
  // Tension k (d - l0) = m omega^2 d / 2.
  const double stiffness = omega * omega * distance / 2.0 / (distance - rest_length);
  net.add_spring(0, 1, net.add_material(damped(stiffness, 0.0)), rest_length);
  return net;
}

// A free cube of springs, shaken and spinning.
Network free_net(double damping) {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 3};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("net", lattice, Node{}, net.add_material(damped(5.0, damping)));
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    node.mass = 0.5 + 0.1 * (k % 4);
    const double phase = k;
    node.velocity = Vector3(0.2 * std::sin(3 * phase), 0.2 * std::cos(5 * phase), 0.2 * std::sin(7 * phase)) +
                    Vector3(0.1, 0.2, -0.3) + Vector3(0, 0, 0.3).cross(node.position);
    net.set_node(k, node);
  }
  return net;
}

}  // namespace

TEST_CASE("free fall") {
  const Vector3 start(1, 2, 3), velocity(0.5, -0.3, 4.0), g(0.1, 0, -9.81);
  constexpr double h = 0.02, end = 2.0;
  for (const Method& method : all_methods(1e-12)) {
    CAPTURE(method.name);
    Network net;
    net.add_node(point(start, 0.3, velocity));
    net.set_gravity(g);
    Simulation simulation = simulate(net, method.integrator, h);
    simulation.advance_to(end);
    // Both Euler methods give v + g t exactly and move with the velocity at the end of each step: g t h / 2 further.
    const double more = method.order == Order::reference ? 0.0 : h;
    const Vector3 expected = start + velocity * end + 0.5 * g * end * (end + more);
    // 100 steps of rounding of some 20 m; the reference: scales 1 m and 4 m/s, over 2 s.
    const double bound = method.order == Order::reference ? 10 * reference_error(simulation) : 1e-12;
    CHECK((simulation.position(0) - expected).norm() < bound);
    CHECK((simulation.velocity(0) - (velocity + g * end)).norm() < bound);
  }
}

TEST_CASE("rotating pair: angular momentum over one turn") {
  constexpr double omega = 0.79, h = 0.05;
  const double turn = 2 * std::numbers::pi / omega;
  for (const Method& method : all_methods(1e-12)) {
    CAPTURE(method.name);
    Simulation simulation = simulate(rotating_pair(omega, 2.0, 1.0), method.integrator, h);
    const double before = simulation.angular_momentum()[2];
    double expected = before;
    const double stiffness = omega * omega * 1.0 / (2.0 - 1.0);
    while (simulation.time() < turn - h / 2) {
      simulation.step();
      // Backward Euler, whose force is along the new position, divides L by 1 + h^2 omega^2, with the omega^2 = 2 T /
      // (m d) of the new distance: p x v = (P - h U) x (U - h F / m), U x F = 0 but for P x U.
      const double distance = (simulation.position(0) - simulation.position(1)).norm();
      expected /= 1.0 + h * h * 2.0 * stiffness * (distance - 1.0) / distance;
    }
    const double after = simulation.angular_momentum()[2];
    switch (method.order) {
      case Order::fixed_point:
        CHECK(after == doctest::Approx(expected).epsilon(1e-11));  // settling tolerance and rounding, 160 steps
        CHECK(1.0 - after / before == doctest::Approx(0.22).epsilon(0.05));
        break;
      case Order::single_sweep:
        CHECK(after == doctest::Approx(before).epsilon(1e-13));  // rounding of 160 steps
        break;
      case Order::reference:
        CHECK(std::abs(after - before) < 2 * reference_error(simulation) * before);
        break;
    }
  }
}

TEST_CASE("rotating pair: axial damping does not affect the rotation, relative damping brakes it") {
  // d |Δv| = 2 d omega r on each node: L falls as exp(-2 d t / m).
  constexpr double omega = 0.79, end = 2.0, damping = 0.1, h = 1e-3;
  for (const Method& method : all_methods(1e-12)) {
    CAPTURE(method.name);
    for (const bool relative : {false, true}) {
      CAPTURE(relative);
      Network net = rotating_pair(omega, 2.0, 1.0);
      Material material = net.materials()[0];
      material.viscosity = LawUse{relative ? "relative" : "linear", {{"damping", damping}}};
      net.set_spring_material(0, net.add_material(material));
      Simulation simulation = simulate(net, method.integrator, h);
      const double before = simulation.angular_momentum()[2];
      simulation.advance_to(end);
      const double expected = relative ? std::exp(-2 * damping * end) : 1.0;
      // First order: (2 d)^2 h t / 2 of relative damping; the fixed point loses h omega^2 t besides.
      double bound = 1.1 * h * end * (2 * damping * damping + omega * omega);
      if (method.order == Order::single_sweep)
        bound = relative ? 1.1 * h * end * 2 * damping * (damping + omega) : 1e-12;
      if (method.order == Order::reference) bound = 2 * reference_error(simulation);
      CHECK(std::abs(simulation.angular_momentum()[2] / before - expected) < bound);
    }
  }
}

TEST_CASE("momentum of a free net") {
  constexpr double h = 0.02, end = 4.0, force_tolerance = 1e-11;
  for (const double damping : {0.0, 0.5}) {
    for (const Method& method : all_methods(force_tolerance)) {
      CAPTURE(damping);
      CAPTURE(method.name);
      Simulation simulation = simulate(free_net(damping), method.integrator, h);
      const Vector3 before = simulation.momentum();
      simulation.advance_to(end);
      // Forces are in pairs: synchronous sweeps keep it to rounding. A wavefront computes both ends of a spring from
      // outputs of different age: what is left is 27 nodes times the tolerance over 4 s.
      double bound = 1e-12;
      if (method.name == "wavefront") bound = 27 * force_tolerance * end;
      if (method.order == Order::reference) bound = 27 * reference_error(simulation);
      CHECK((simulation.momentum() - before).norm() < bound);
    }
  }
}

TEST_CASE("energy and angular momentum of a free undamped net") {
  constexpr double end = 1.0;
  const auto energy = [](const Simulation& s) { return s.kinetic_energy() + s.potential_energy(); };
  for (const Method& method : all_methods(1e-10)) {
    CAPTURE(method.name);
    std::vector<double> deviation, loss;
    for (const double h : {0.002, 0.001}) {
      Simulation simulation = simulate(free_net(0.0), method.integrator, h);
      const double before = energy(simulation);
      const Vector3 turning = simulation.angular_momentum();
      double last = before, greatest = 0.0;
      bool falls = true;
      while (simulation.time() < end - h / 2) {
        simulation.step();
        falls = falls && energy(simulation) < last;
        last = energy(simulation);
        greatest = std::max(greatest, std::abs(last - before));
      }
      deviation.push_back(greatest);
      loss.push_back(before - last);
      switch (method.order) {
        case Order::fixed_point:
          CHECK(falls);
          break;  // of a potential: every step dissipates
        case Order::single_sweep:
          // Forces along the springs at the positions that the step starts from: exact but for rounding of 1000 steps.
          CHECK((simulation.angular_momentum() - turning).norm() < 1e-12);
          break;
        case Order::reference:
          // 27 nodes with momenta below 1 kg m/s each.
          CHECK(greatest < 27 * reference_error(simulation));
          CHECK((simulation.angular_momentum() - turning).norm() < 27 * 3 * reference_error(simulation));
          break;
      }
    }
    // First order, both: half the step, half the loss or half the swing. A mode loses 1 - exp(-h omega^2 t), and no
    // mode has more than omega^2 = 2 k 6 / m = 120/s^2: the second-order terms are below h omega^2 t / 2 = 0.12.
    if (method.order == Order::fixed_point) CHECK(loss[0] / loss[1] == doctest::Approx(2.0).epsilon(0.12));
    if (method.order == Order::single_sweep) CHECK(deviation[0] / deviation[1] == doctest::Approx(2.0).epsilon(0.12));
  }
}
