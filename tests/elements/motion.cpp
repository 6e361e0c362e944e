// Closed forms: oscillators of every invariant, a cantilever of hinges, Laplace's law of a filled bubble; what a sweep
// conserves.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "bodies.hpp"
#include "methods.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// One free node whose coordinate `read` is a damped harmonic oscillator of any amplitude.
struct Oscillator {
  std::string name;
  Network net;
  double inertia;                  // of the coordinate, kg m^2 over (unit of q)^2
  double start;                    // of the coordinate at rest, in units of q from the reference
  double (*read)(const Vector3&);  // q - reference, signed
  NodeIndex node;
};

constexpr double stiffness = 3.0, damping = 0.4, mass = 0.7;

std::vector<Oscillator> oscillators() {
  std::vector<Oscillator> all;
  const auto fixed = [](Network& net, const Vector3& p) { net.fix(net.add_node(point(p))); };
  {
    // A rod of 0.8 m at the end of a bar along x: inertia m L^2 about the joint. It swings through the straight shape.
    Network net;
    fixed(net, {-1, 0, 0});
    fixed(net, {0, 0, 0});
    net.add_node(point(0.8 * Vector3(std::cos(0.6), 0, std::sin(0.6)), mass));
    net.add_rigid(1, 2);
    net.add_element(Invariant::angle, {0, 1, 2}, net.add_material(damped(stiffness, damping)), std::numbers::pi);
    all.push_back({"angle", net, mass * 0.64, 0.6, [](const Vector3& p) { return std::atan2(p.z(), p.x()); }, 2});
  }
  {
    // A wing of 0.5 m hinged to the x axis, from 1.0 rad about a rest at 0.3 rad: inertia m H^2. The wing at angle q
    // lies at (-y, -z) turned.
    Network net;
    fixed(net, {0, 0, 0});
    fixed(net, {1, 0, 0});
    fixed(net, {0.4, 1.2, 0});
    net.add_node(point({0.3, -0.5 * std::cos(1.0), -0.5 * std::sin(1.0)}, mass));
    net.add_rigid(0, 3);
    net.add_rigid(1, 3);
    net.add_element(Invariant::dihedral, {0, 1, 2, 3}, net.add_material(damped(stiffness, damping)), 0.3);
    all.push_back(
        {"dihedral", net, mass * 0.25, 0.7, [](const Vector3& p) { return std::atan2(-p.z(), -p.y()) - 0.3; }, 3});
  }
  {
    // Height z over a base of 1.6 m: A = 0.8 z.
    Network net;
    fixed(net, {0, 0, 0});
    fixed(net, {1.6, 0, 0});
    net.add_node(point({0.4, 0, 1.5}, mass));
    net.add_element(Invariant::area, {0, 1, 2}, net.add_material(damped(stiffness, damping)), 0.8);
    all.push_back({"area", net, mass / 0.64, 0.4, [](const Vector3& p) { return 0.8 * p.z() - 0.8; }, 2});
  }
  for (const bool enclosed : {false, true}) {
    // Height z over a base of 3 m^2: V = z.
    Network net;
    fixed(net, {0, 0, 0});
    fixed(net, {3, 0, 0});
    fixed(net, {0, 2, 0});
    net.add_node(point({0.5, 0.4, 1.5}, mass));
    const MaterialIndex material = net.add_material(damped(stiffness, damping));
    if (enclosed)
      net.add_element(Invariant::enclosed_volume, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}, material, 1.0);
    else
      net.add_element(Invariant::volume, {0, 1, 2, 3}, material, 1.0);
    all.push_back(
        {enclosed ? "enclosed volume" : "volume", net, mass, 0.5, [](const Vector3& p) { return p.z() - 1.0; }, 3});
  }
  return all;
}

double swing(const Oscillator& o, double time) {
  const double rate = 0.5 * damping / o.inertia, frequency = std::sqrt(stiffness / o.inertia - rate * rate);
  return o.start * std::exp(-rate * time) *
         (std::cos(frequency * time) + rate / frequency * std::sin(frequency * time));
}

}  // namespace

TEST_CASE("an oscillator of every invariant moves as in closed form, in CVODE and in the network") {
  for (const Oscillator& o : oscillators()) {
    CAPTURE(o.name);
    CHECK(std::abs(o.read(o.net.nodes()[o.node].position) - o.start) < 1e-15);
    constexpr double until = 2.0;
    Simulation reference = simulate(o.net, cvode(reference_tolerance), 0.1);
    reference.advance_to(until);
    CHECK(std::abs(o.read(reference.position(o.node)) - swing(o, until)) < 10.0 * reference_error(reference));

    const auto error = [&](double step, double theta, double rule) {
      Simulation network = simulate(o.net, recurrent(rule, 1e-11, {{"theta", theta}}), step);
      network.advance_to(until);
      return std::abs(o.read(network.position(o.node)) - swing(o, until));
    };
    for (const double rule : {wavefront, block, newton}) {
      CAPTURE(rule);
      // Errors of the order that theta promises: halving the step divides them by 2 and 4, up to the next order.
      const double coarse = error(0.01, 1.0, rule), fine = error(0.005, 1.0, rule);
      CHECK(coarse / fine > 1.85);
      CHECK(coarse / fine < 2.15);
      const double coarse_half = error(0.02, 0.5, rule), fine_half = error(0.01, 0.5, rule);
      CHECK(coarse_half / fine_half > 3.6);
      CHECK(coarse_half / fine_half < 4.4);
    }
  }
}

TEST_CASE("a straight chain of hinges bends as a cantilever does, from the first step of Newton's method") {
  constexpr int joints = 20;
  constexpr double spacing = 0.05, bending = 2.0, load = 1e-4;
  Network net;
  const Vector3 along = Vector3(1, 2, 2) / 3.0, across = Vector3(2, 1, -2) / 3.0;
  for (int k = 0; k < joints + 2; ++k) net.add_node(point(k * spacing * along));
  net.fix(0);
  net.fix(1);
  const MaterialIndex stiff = net.add_material(damped(1e4, 0.0)), hinge = net.add_material(damped(bending, 0.0));
  for (NodeIndex k = 0; k + 1 < joints + 2; ++k) net.add_spring(k, k + 1, stiff);
  for (NodeIndex k = 0; k + 2 < joints + 2; ++k)
    net.add_element(Invariant::angle, {k, k + 1, k + 2}, hinge, std::numbers::pi);
  net.add_load({{joints + 1}, load * across});
  // One step so long that inertia does not matter: m / t_c^2 is 1e-12 of the stiffness.
  // The tolerance is above the rounding of the springs, 1e4 N/m times 1e-16 m.
  Simulation simulation = simulate(net, recurrent(newton, 1e-10), 1e6);
  CHECK(simulation.step().outcome == Outcome::settled);
  // Each joint turns by its moment over its stiffness: sum F x^2 / k over the arms x of the load.
  double expected = 0.0;
  for (int k = 1; k <= joints; ++k) expected += load * (k * spacing) * (k * spacing) / bending;
  const double found = (simulation.position(joints + 1) - net.nodes()[joints + 1].position).dot(across);
  CHECK(found == doctest::Approx(expected).epsilon(1e-5));  // angles of 1e-3 in sum: cosines differ by 1e-6
}

TEST_CASE("a bubble of constant surface tension has the pressure of Laplace's law") {
  const TriangleMesh mesh = icosphere(2, 0.1);
  constexpr double tension = 0.05, far = 1e4, bulk = 1e7;
  Network net;
  for (const Vector3& p : mesh.points) net.add_node(point(p, 1e-3));
  // Q = k (A - A_0) with a far A_0 < 0: the same tension for every area, to 1e-6.
  const MaterialIndex skin = net.add_material({LawUse{"linear", {{"stiffness", tension / far}}}, std::nullopt});
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    net.add_element(Invariant::area, {mesh.triangles[t], mesh.triangles[t + 1], mesh.triangles[t + 2]}, skin, -far);
  const ElementIndex filling =
      net.add_element(Invariant::enclosed_volume, mesh.triangles, net.add_material(damped(bulk, 0.0)));
  Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.5);
  for (int i = 0; i < 60; ++i) CHECK(simulation.step().outcome == Outcome::settled);
  double area = 0.0;
  for (ElementIndex e = 0; e < filling; ++e) area += simulation.element_value(e);
  const double pressure = -simulation.element_force(filling), volume = simulation.element_value(filling);
  // Areas are homogeneous of degree 2, the volume of degree 3: 2 tension A = 3 p V in equilibrium, whatever the shape.
  // What is left of the motion is damped by the method: 1e-6 of the pressure, as that of the tension.
  CHECK(pressure == doctest::Approx(2.0 * tension * area / (3.0 * volume)).epsilon(1e-5));
  CHECK(pressure == doctest::Approx(2.0 * tension / 0.1).epsilon(0.03));  // 320 flat triangles
}

TEST_CASE("a single sweep conserves momentum and angular momentum, with elements of every kind") {
  const Network net = all_kinds(12);
  Simulation simulation = simulate(net, single_sweep(), 1e-3);
  const Vector3 momentum = simulation.momentum(), angular = simulation.angular_momentum();
  const Vector3 before = simulation.position(2);
  for (int i = 0; i < 200; ++i) simulation.step();
  CHECK((simulation.position(2) - before).norm() > 1e-3);
  // 200 sums over some hundred forces, each rounded at 1e-16 of numbers of order 10.
  CHECK((simulation.momentum() - momentum).norm() < 1e-12);
  CHECK((simulation.angular_momentum() - angular).norm() < 1e-12);
}

TEST_CASE("the energy of a net of undamped elements is conserved in the reference") {
  const Network net = all_kinds(12, false);
  Simulation simulation = simulate(net, cvode(1e-9), 0.05);
  const double before = simulation.potential_energy() + simulation.kinetic_energy();
  // As long as no hinge is folded over: its angle jumps by a full turn there, and the energy with it.
  simulation.advance_to(0.1);
  CHECK(std::abs(simulation.kinetic_energy() + simulation.potential_energy() - before) < 1e-6 * before);
}

TEST_CASE("a straight chain with damped angles that is struck sideways keeps its second order") {
  // Its dampers act from the first moment, though an angle of exactly pi has no direction.
  Network net;
  const MaterialIndex rope = net.add_material(damped(100.0, 0.0));
  for (NodeIndex k = 0; k < 5; ++k) {
    net.add_node(point({static_cast<double>(k), 0, 0}, 1.0, {0, 0, k % 2 == 0 ? 0.2 : -0.3}));
    if (k > 0) net.add_spring(k - 1, k, rope);
  }
  const MaterialIndex joint = net.add_material(damped(2.0, 2.0));
  for (NodeIndex k = 1; k < 4; ++k) net.add_element(Invariant::angle, {k - 1, k, k + 1}, joint, std::numbers::pi);
  const double until = 1.0;
  Simulation reference = simulate(net, cvode(1e-10), until);
  reference.step();
  for (const LawUse& method : {recurrent(newton, 1e-12, {{"theta", 0.5}}), LawUse{"verlet", {}}, generalized_alpha()}) {
    CAPTURE(method.id);
    double error[2];
    for (int i = 0; i < 2; ++i) {
      Simulation simulation = simulate(net, method, i == 0 ? 0.01 : 0.005);
      simulation.advance_to(until);
      error[i] = 0.0;
      for (NodeIndex k = 0; k < 5; ++k)
        error[i] = std::max(error[i], (simulation.position(k) - reference.position(k)).norm());
    }
    CHECK(error[0] < 1e-3);
    CHECK(std::log2(error[0] / error[1]) > 1.8);  // 1.0 if the dampers came a step late
  }
}
