// States of rest, the forces that hold them, and springs between bodies.
#include <cmath>
#include <cstdint>

#include <doctest/doctest.h>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

constexpr double gravity = 9.81, mass = 0.2, stiffness = 40.0;

// Nodes 0 … count hanging down from node 0, which is fixed; in a viscous medium, so that they come to rest.
Network hanging_chain(std::uint32_t count) {
  Network net = chain(count + 1, Vector3::Zero(), {0, 0, -0.5}, damped(stiffness, 1.0), mass);
  const std::uint32_t medium = net.add_neuron({"dragged", {{"drag", 0.8}}});
  for (NodeIndex k = 0; k <= count; ++k) {
    Node node = net.nodes()[k];
    node.neuron = medium;
    node.fixed = k == 0;
    net.set_node(k, node);
  }
  net.set_gravity({0, 0, -gravity});
  return net;
}

}  // namespace

TEST_CASE("sag of a hanging chain: each spring carries the weight below it") {
  constexpr std::uint32_t count = 6;
  constexpr double force_tolerance = 1e-10;
  for (const Method& method : all_methods(force_tolerance)) {
    CAPTURE(method.name);
    // The slowest mode falls as exp(-2.4 t): rest to 1e-15 of the first motion after 15 s.
    Simulation simulation = simulate(hanging_chain(count), method.integrator, 0.02);
    simulation.advance_to(15.0);
    // A force tolerance moves a node by that over the softest mode, k / 20. The reference may keep its own error.
    double bound = 20 * force_tolerance / stiffness;
    if (method.order == Order::single_sweep) bound = 1e-12;
    if (method.order == Order::reference) bound = reference_error(simulation);
    double z = 0.0;
    for (std::uint32_t k = 1; k <= count; ++k) {
      const double carried = (count - k + 1) * mass * gravity;
      z -= 0.5 + carried / stiffness;
      CHECK(std::abs(simulation.position(k)[2] - z) < bound);
      CHECK(std::abs(simulation.tension(k - 1) - carried) < 2 * stiffness * bound);
    }
    // The ceiling holds the chain, and the end of the chain itself.
    const double weight = (count + 1) * mass * gravity;
    CHECK((simulation.reaction(0) - Vector3(0, 0, weight)).norm() < 2 * stiffness * bound);
    CHECK(simulation.reaction(1) == Vector3::Zero());
    CHECK(simulation.position(0).norm() < 1e-20);  // rounding in the linear solver of the reference
  }
}

TEST_CASE("reaction forces of two fixed nodes share a load by the lever of its place") {
  // A node between two walls, 4 and 1 N/m away: rigidities in series. Pulled along x by 2 N.
  Network net;
  const MaterialIndex soft = net.add_material(damped(1.0, 0.5)), hard = net.add_material(damped(4.0, 0.5));
  for (const double x : {0.0, 1.0, 2.0}) net.add_node(point({x, 0, 0}));
  net.fix(0);
  net.fix(2);
  net.add_spring(0, 1, soft);
  net.add_spring(2, 1, hard);
  net.add_load({{1}, {2, 0, 0}});
  for (const Method& method : all_methods(1e-11)) {
    CAPTURE(method.name);
    Simulation simulation = simulate(net, method.integrator, 0.05);
    simulation.advance_to(60.0);  // exp(-0.5 t): at rest to 1e-13
    const double bound = method.order == Order::reference ? 10 * reference_error(simulation) : 1e-9;
    CHECK((simulation.reaction(0) - Vector3(-0.4, 0, 0)).norm() < bound);
    CHECK((simulation.reaction(2) - Vector3(-1.6, 0, 0)).norm() < bound);
    CHECK((simulation.position(1) - Vector3(1.4, 0, 0)).norm() < bound);
  }
}

TEST_CASE("a spring between two bodies: reduced mass") {
  // Two bodies of one node each; relative motion at omega^2 = k (1 / m1 + 1 / m2), centre of mass at rest.
  constexpr double m1 = 0.5, m2 = 2.0, k = 1.6, stretch = 0.1, h = 1e-3, end = 3.0;
  Network net;
  net.begin_body("left");
  net.add_node(point({0, 0, 0}, m1));
  net.end_body();
  net.begin_body("right");
  net.add_node(point({1.0 + stretch, 0, 0}, m2));
  net.end_body();
  net.add_spring(0, 1, net.add_material(damped(k, 0.0)), 1.0);
  const double omega = std::sqrt(k * (1 / m1 + 1 / m2));
  const double centre = m2 * (1.0 + stretch) / (m1 + m2);
  for (const Method& method : all_methods(1e-11)) {
    CAPTURE(method.name);
    Simulation simulation = simulate(net, method.integrator, h);
    simulation.advance_to(end);
    const double distance = simulation.position(1)[0] - simulation.position(0)[0];
    // Backward Euler: h omega^2 t / 2 of the amplitude; symplectic Euler: h omega / 2.
    double bound = 1.1 * stretch * h * omega * omega * end / 2;
    if (method.order == Order::single_sweep) bound = 1.1 * stretch * h * omega / 2;
    if (method.order == Order::reference) bound = 2 * reference_error(simulation);
    CHECK(std::abs(distance - 1.0 - stretch * std::cos(omega * end)) < bound);
    // In pairs to rounding; a wavefront to its tolerance.
    const Vector3 centre_now = (m1 * simulation.position(0) + m2 * simulation.position(1)) / (m1 + m2);
    const double keeps = method.order == Order::reference ? 2 * reference_error(simulation) : 1e-10;
    CHECK((centre_now - Vector3(centre, 0, 0)).norm() < keeps);
  }
}
