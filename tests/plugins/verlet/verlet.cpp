// The velocity Verlet integrator, checked as the others are: closed forms, conservation, events, and its limit.

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

LawUse verlet(double substeps = 1) { return {"verlet", {{"substeps", substeps}}}; }

double error_of(const Network& net, double time_step, double until, double exact) {
  Simulation simulation = simulate(net, verlet(), time_step);
  simulation.advance_to(until);
  return std::abs(simulation.position(1)[0] - 1.0 - exact);
}

}  // namespace

TEST_CASE("an oscillator, free and damped, is followed with second order") {
  const double stiffness = 40.0, mass = 0.5, start = 0.1, until = 1.3;  // N/m, kg, m, s
  const double omega = std::sqrt(stiffness / mass);
  for (const double damping : {0.0, 0.6}) {
    CAPTURE(damping);
    const double decay = damping / (2.0 * mass), damped_omega = std::sqrt(omega * omega - decay * decay);
    const double exact = start * std::exp(-decay * until) *
                         (std::cos(damped_omega * until) + decay / damped_omega * std::sin(damped_omega * until));
    const Network net = oscillator(damped(stiffness, damping), mass, start);
    const double coarse = error_of(net, 0.01, until, exact), fine = error_of(net, 0.005, until, exact);
    CHECK(std::log2(coarse / fine) == doctest::Approx(2.0).epsilon(0.05));  // the next term is (omega h)^2 = 1 % of it
    // The phase runs ahead by (omega h)^2 / 24 a radian; damping adds as much.
    CHECK(fine < 3.0 * start * omega * until * std::pow(omega * 0.005, 2) / 24.0);
  }
}

TEST_CASE("the free oscillator's frequency is the discrete one, to rounding") {
  // cos(W h) = 1 - (omega h)^2 / 2: the exact solution of the method, at any step below its limit.
  const double omega = 3.0, h = 0.2;
  Simulation simulation = simulate(oscillator(damped(omega * omega, 0.0), 1.0, 0.25), verlet(), h);
  const double angle = std::acos(1.0 - 0.5 * omega * omega * h * h);
  for (int i = 1; i <= 1000; ++i) {
    simulation.step();
    CHECK(std::abs(simulation.position(1)[0] - 1.0 - 0.25 * std::cos(angle * i)) <= 1e-11);  // 1000 roundings
  }
}

TEST_CASE("energy of an undamped lattice oscillates without drift, momentum is kept to rounding") {
  Lattice lattice;
  lattice.nodes = {4, 4, 4};
  lattice.diagonals = Diagonals::all;
  Network net;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(30.0, 0.0)));
  for (NodeIndex k = 0; k < 64; ++k) {
    Node node = net.nodes()[k];
    node.velocity = {0.1 * std::sin(k), 0.1 * std::cos(2.0 * k), 0.05 * std::sin(3.0 * k)};
    net.set_node(k, node);
  }
  Simulation simulation = simulate(net, verlet(), 0.02);
  const double energy = simulation.kinetic_energy() + simulation.potential_energy();
  const Vector3 momentum = simulation.momentum(), spin = simulation.angular_momentum();
  double early = 0.0, late = 0.0;
  for (int i = 0; i < 4000; ++i) {
    simulation.step();
    const double off = simulation.kinetic_energy() + simulation.potential_energy() - energy;
    (i < 2000 ? early : late) += off / 2000.0;
  }
  CHECK(std::abs(early) <= 0.02 * energy);  // (omega h)^2 / 8 with omega h up to 0.4
  CHECK(std::abs(late - early) <= 1e-3 * energy);
  CHECK((simulation.momentum() - momentum).norm() <= 1e-12);
  CHECK((simulation.angular_momentum() - spin).norm() <= 1e-11);
}

TEST_CASE("substeps give the motion of steps of their length") {
  const Network net = cube(30.0, 0.5, 1.0, 0.05);
  Simulation whole = simulate(net, verlet(), 0.005), divided = simulate(net, verlet(4), 0.02);
  whole.advance_to(1.0);
  divided.advance_to(1.0);
  for (NodeIndex k = 0; k < 64; ++k)
    CHECK((whole.position(k) - divided.position(k)).norm() <= 1e-12);  // times differ in their last digits
}

TEST_CASE("a step above the limit of stability is refused with the limit, a step below it is accepted") {
  const double omega = 10.0;
  const Network net = oscillator(damped(omega * omega, 0.0), 1.0, 0.1);
  Simulation below = simulate(net, verlet(), 1.99 / omega);
  for (int i = 0; i < 1000; ++i) below.step();
  CHECK(std::abs(below.position(1)[0] - 1.0) <= 1.1);  // amplitude / sqrt(1 - (omega h / 2)^2)
  Simulation above = simulate(net, verlet(), 2.01 / omega);
  CHECK_THROWS_WITH_AS(above.step(), doctest::Contains(" 0.2 s"), Error);
  // As many substeps as the error advises are enough.
  Simulation divided = simulate(net, verlet(2), 2.01 / omega);
  CHECK_NOTHROW(divided.step());
}

TEST_CASE("a spring that stiffens past the limit is detected, though nothing changes but the motion") {
  Network net;
  Node wall = point(Vector3::Zero());
  wall.fixed = true;
  net.add_node(wall);
  net.add_node(point({1.0, 0, 0}, 1.0));
  net.add_spring(0, 1,
                 net.add_material({LawUse{"exponential", {{"stiffness", 10.0}, {"exponent", 8.0}}},
                                   LawUse{"linear", {{"damping", 0.5}}}}),
                 1.0);
  Load pull{{1}, {60.0, 0, 0}};
  pull.course.ramp = 115.0;
  net.add_load(pull);
  constexpr double h = 0.12;
  Simulation simulation = simulate(net, verlet(), h);
  CHECK_THROWS_WITH_AS(simulation.advance_to(200.0), doctest::Contains("limit of stability"), Error);
  // The spring's stiffness is k = 10 N/m exp(8 e) = 10 N/m + 8 T under the tension T: h^2 k / 4 + h d = m at 31 N,
  // after 60 s, and the check is every 256 steps, in time before the motion grows.
  CHECK(simulation.time() > 59.0);
  CHECK(simulation.time() <= 2.1 * 256 * h);
}

TEST_CASE("changes between two steps take effect in the next step") {
  constexpr double h = 0.1, mass = 2.0;
  Network net;
  net.add_node(point(Vector3::Zero(), mass));
  net.add_node(point({1.5, 0, 0}, mass));
  net.add_spring(0, 1, net.add_material(damped(4.0, 0.0)), 1.0);
  Simulation simulation = simulate(net, verlet(), h);
  simulation.step();
  simulation.cut({0});
  const auto check_step = [&](const Vector3& force) {
    const Vector3 before = simulation.position(1), velocity = simulation.velocity(1), gain = h / mass * force;
    simulation.step();
    CHECK((simulation.position(1) - before - h * velocity - 0.5 * h * gain).norm() <= 1e-15);
    CHECK((simulation.velocity(1) - velocity - gain).norm() <= 1e-15);
  };
  check_step(Vector3::Zero());
  simulation.set_force(1, {0, 3, 0});
  check_step({0, 3, 0});
  simulation.set_force(1, Vector3::Zero());
  check_step(Vector3::Zero());
  simulation.set_gravity({0, 0, -5});
  check_step({0, 0, -5 * mass});
}

TEST_CASE("cuts, ruptures and contacts happen as in the reference, within a step") {
  Network net = cube(30.0, 1.0, 2.0, 0.05);
  net.add_cut({0.4, {0, 1, 2}, {}});
  const MaterialIndex weak =
      net.add_material({LawUse{"rupturing", {{"stiffness", 5.0}, {"strength", 0.1}}}, std::nullopt});
  for (const SpringIndex s : {50u, 90u, 130u}) net.set_spring_material(s, weak);
  Simulation reference = simulate(net, cvode(1e-9), 0.002), simulation = simulate(net, verlet(), 0.002);
  reference.advance_to(0.8);
  simulation.advance_to(0.8);
  CHECK(simulation.live_spring_count() == reference.live_spring_count());
  CHECK(simulation.live_spring_count() < 252 - 3);
  double worst = 0.0;
  for (NodeIndex k = 0; k < 64; ++k) worst = std::max(worst, (simulation.position(k) - reference.position(k)).norm());
  CHECK(worst <= 2e-3 * 1.0);  // events within a step of 2 ms, at up to 1 m/s
}
