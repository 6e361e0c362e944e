// Nodes whose position is prescribed: where they are, what moving them takes, what they move.

#include <doctest/doctest.h>

#include <numbers>

#include "ways.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double frequency = 0.8, amplitude = 0.05, stiffness = 50.0, mass = 0.4;  // Hz, m, N/m, kg
constexpr double turn = 2.0 * std::numbers::pi * frequency;                        // rad/s

// A mass on a spring whose other end is shaken along it.
Network shaken() {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}, mass));
  net.add_spring(0, 1, net.add_material(damped(stiffness, 0.0)), 1.0);
  Move move;
  move.nodes = {0};
  move.motion.amplitude = {amplitude, 0, 0};
  move.motion.frequency = frequency;
  net.add_move(move);
  return net;
}

}  // namespace

TEST_CASE("a mass on a shaken spring follows the closed form, and moving the spring takes its force") {
  // m x'' = -k (x - A sin wt), from rest: x = A w0^2 / (w0^2 - w^2) (sin wt - w / w0 sin w0 t).
  const Network net = shaken();
  const double natural = std::sqrt(stiffness / mass), time = 0.9;
  const double gain = amplitude * natural * natural / (natural * natural - turn * turn);
  const double x = gain * (std::sin(turn * time) - turn / natural * std::sin(natural * time));
  for (const Way& way : all_ways(1e-10)) {
    INFO(way.name);
    Simulation simulation = simulate(net, way.integrator, 0.001);
    simulation.advance_to(time);
    // Phase errors of order h w0^2 t / 2 and h^2 w0^3 t / 12 a radian.
    const double share = way.order == 1.0 ? 0.06 : way.order == 2.0 ? 3e-4 : 1e-6;
    CHECK(std::abs(simulation.position(1)[0] - 1.0 - x) <= share * gain);
    const double moved = amplitude * std::sin(turn * time);
    CHECK(simulation.position(0)[0] == doctest::Approx(moved).epsilon(1e-14));
    CHECK(simulation.velocity(0)[0] == doctest::Approx(amplitude * turn * std::cos(turn * time)).epsilon(1e-12));
    // What moves the node accelerates its own mass, 1 kg, and stretches the spring.
    const double stretch = simulation.position(1)[0] - simulation.position(0)[0] - 1.0;
    const double force = -amplitude * turn * turn * std::sin(turn * time) - stiffness * stretch;
    CHECK(simulation.reaction(0)[0] == doctest::Approx(force).epsilon(1e-9));
  }
}

TEST_CASE("the work of moving a node goes into the net") {
  // A spring between a node that is pulled 0.2 m in 1 s, then rests, and a fixed one; the work is the spring's energy.
  Network net;
  net.add_node(point({0, 0, 0}, 0.1));
  net.add_node(point({1, 0, 0}, 0.1));
  net.fix(1);
  net.add_spring(0, 1, net.add_material(damped(stiffness, 0.0)), 1.0);
  Move move;
  move.nodes = {0};
  move.motion.times = {0.0, 1.0};
  move.motion.displacements = {Vector3::Zero(), Vector3(-0.2, 0, 0)};
  net.add_move(move);
  for (const Way& way : all_ways(1e-9)) {
    INFO(way.name);
    Simulation simulation = simulate(net, way.integrator, 0.005);
    double work = 0.0;
    Vector3 force = simulation.reaction(0), velocity = simulation.velocity(0);
    for (int i = 0; i < 240; ++i) {
      simulation.step();
      const double power = force.dot(velocity);
      force = simulation.reaction(0);
      velocity = simulation.velocity(0);
      work += 0.5 * 0.005 * (power + force.dot(velocity));
    }
    CHECK((simulation.position(0) - Vector3(-0.2, 0, 0)).norm() <= 1e-12);
    CHECK(simulation.velocity(0).norm() == 0.0);
    // The trapezoidal sum over 200 steps of a smooth power: relative error about (pi / 200)^2 / 12.
    CHECK(work == doctest::Approx(0.5 * stiffness * 0.04).epsilon(1e-3));
  }
}

TEST_CASE("a host moves a node and a surface from where they are to where it says") {
  Network net = shaken();
  Plane floor;
  floor.name = "floor";
  floor.point = {0, 0, -1};
  net.add_plane(floor);
  for (const Way& way : {Way{"recurrent", recurrent(newton, 1e-9), 1.0}, Way{"cvode", cvode(1e-8), 0.0},
                         Way{"verlet", {"verlet", {}}, 2.0}}) {
    INFO(way.name);
    Simulation simulation = simulate(net, way.integrator, 0.01);
    simulation.advance_to(0.1);
    const Vector3 before = simulation.position(0);
    simulation.move_node(0, before + Vector3(0, 0.1, 0), 0.2);
    simulation.move_surface(0, {0, 0, -0.9}, 0.3);
    simulation.advance_to(0.15);
    // To the rounding of the times.
    CHECK((simulation.position(0) - before - Vector3(0, 0.05, 0)).norm() <= 1e-12);
    CHECK((simulation.velocity(0) - Vector3(0, 1.0, 0)).norm() <= 1e-9);
    CHECK((simulation.surface_position(0) - Vector3(0, 0, -0.975)).norm() <= 1e-12);
    simulation.advance_to(0.4);
    CHECK((simulation.position(0) - before - Vector3(0, 0.1, 0)).norm() <= 1e-12);
    CHECK(simulation.velocity(0).norm() == 0.0);
    CHECK((simulation.surface_position(0) - Vector3(0, 0, -0.9)).norm() <= 1e-12);
    CHECK_THROWS_AS(simulation.move_node(0, before, 0.3), std::exception);  // that time is past
  }
}
