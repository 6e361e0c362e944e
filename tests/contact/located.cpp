// Located events in the network: steps that are divided where nodes touch, leave, and springs break or are cut.

#include <doctest/doctest.h>

#include <cmath>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

LawUse located(double update, double theta) { return recurrent(update, 1e-11, {{"theta", theta}, {"events", 1.0}}); }

// A node that falls, with springs to its sides of which one breaks and one is cut.
Network breaking() {
  Network net;
  Node left = point({-1, 0, 0}), right = point({1, 0, 0.1}), above = point({0.1, 0.2, 1});
  left.fixed = right.fixed = above.fixed = true;
  net.add_node(left);
  net.add_node(right);
  net.add_node(above);
  net.add_node(point({0, 0, 0}, 0.5));
  net.add_spring(0, 3, net.add_material(damped(20.0, 0.1)));
  net.add_spring(1, 3, net.add_material({LawUse{"rupturing", {{"stiffness", 20.0}, {"strength", 1.5}}}, std::nullopt}));
  net.add_spring(2, 3, net.add_material(damped(15.0, 0.1)));
  net.set_gravity({0, 0, -9.81});
  net.add_cut({0.3137, {2}, {}});
  return net;
}

}  // namespace

TEST_CASE("with located events a step keeps its order through touch and release") {
  const Friction rough{Friction::Kind::coulomb, 0.2};
  struct Example {
    std::string name;
    Network net;
    double until;  // s
  };
  for (const Example& example :
       {Example{"sphere", thrown_on_sphere(frictionless), 1.2}, Example{"rough sphere", thrown_on_sphere(rough), 1.2},
        Example{"capsule", thrown_on_capsule(frictionless), 1.2}, Example{"pair", thrown_pair(), 0.6},
        Example{"box", thrown_box(), 0.55}}) {
    const Truth truth(example.net, example.until);
    for (const double update : {newton, block, wavefront}) {
      for (const double theta : {1.0, 0.5}) {
        INFO(example.name << ", update " << update << ", theta " << theta);
        double error[3];
        for (const int halving : {0, 1, 2}) {
          const Run run = follow(truth, located(update, theta), 0.004 / (1 << halving));
          error[halving] = run.error;
          CHECK(run.pull <= 1e-9);
          CHECK(run.sweeps_per_step < 100.0);  // 47 at most: only steps with an event are divided
        }
        CAPTURE(error[0]);
        CAPTURE(error[1]);
        CAPTURE(error[2]);
        CHECK(0.5 * std::log2(error[0] / error[2]) > (theta == 1.0 ? 0.8 : 1.7));
      }
    }
  }
}

TEST_CASE("with located events a step keeps its order through rupture and cut") {
  const Network net = breaking();
  constexpr double until = 0.6;
  Simulation reference = simulate(net, cvode(1e-11), 0.1);
  reference.advance_to(until);
  REQUIRE(reference.events().size() == 2);
  for (const double update : {newton, block}) {
    double error[3];
    for (const int halving : {0, 1, 2}) {
      Simulation s = simulate(net, located(update, 0.5), 0.004 / (1 << halving));
      s.advance_to(until);
      error[halving] = distance(s, reference);
      REQUIRE(s.events().size() == 2);
      for (const std::size_t i : {0u, 1u})
        CHECK(std::abs(s.events()[i].time - reference.events()[i].time) <= 10.0 * 0.004 * 0.004);
    }
    CAPTURE(error[0]);
    CAPTURE(error[2]);
    CHECK(0.5 * std::log2(error[0] / error[2]) > 1.7);
  }
}

TEST_CASE(
    "with located events a rigid tetrahedron that lands on a surface that holds it rocks, lies still and gains "
    "nothing") {
  struct Example {
    std::string name;
    double mass[4];       // kg
    Vector3 position[4];  // m
  };
  const Example examples[] = {
      {"flat", {1.097, 1.188, 5.947, 0.143}, {{0, 0, 0.012}, {1, 0, 0.01}, {0.3, 0.8, 0.01}, {0.4, 0.3, 0.71}}},
      {"on edge",
       {4.70632, 0.571021, 3.41852, 5.24925},
       {{-0.027, -0.191, 0.999}, {0.026, 0.317, 0.05}, {-0.151, -0.037, 0.264}, {0.152, -0.088, 0.839}}}};
  for (const Example& example : examples) {
    Network net;
    for (const int i : {0, 1, 2, 3}) net.add_node(point(example.position[i], example.mass[i]));
    for (NodeIndex i = 0; i < 4; ++i)
      for (NodeIndex j = i + 1; j < 4; ++j) net.add_rigid(i, j);
    net.set_gravity({0, 0, -9.81});
    net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
    for (const double theta : {1.0, 0.5}) {
      INFO(example.name << ", theta " << theta);
      constexpr double h = 0.004;
      Simulation s = simulate(net, recurrent(newton, 1e-9, {{"theta", theta}, {"events", 1.0}}), h);
      double lowest = s.kinetic_energy() + s.potential_energy(), gained = 0.0, scale = 0.0;
      while (s.time() < 1.5 && steps_on(s)) {
        const double energy = s.kinetic_energy() + s.potential_energy();
        gained = std::max(gained, energy - lowest);
        lowest = std::min(lowest, energy);
        scale = std::max(scale, s.kinetic_energy());
      }
      // Theta 1/2 keeps the energy of a body that turns to the second order of a step.
      CHECK(gained <= (theta == 1.0 ? 1e-12 : h * h) * scale);
      CHECK(s.kinetic_energy() <= 1e-20);
      std::size_t held = 0;
      for (NodeIndex k = 0; k < 4; ++k) held += s.held(k) ? 1 : 0;
      CHECK(held == 3);
      CHECK(worst_length(net, s) <= 1e-9);
    }
  }
}

TEST_CASE("with located events bodies that touch a surface without any load on it have no events") {
  Network net;
  Plane plane;
  plane.friction = {Friction::Kind::coulomb, 0.3};
  net.add_plane(plane);
  net.add_node(point({0, 0, 0}));
  // Two nodes of a relaxed spring that slide along the plane.
  const NodeIndex first = net.add_node(point({1, 0, 0}, 1.0, {0.5, 0, 0}));
  const NodeIndex second = net.add_node(point({2, 0, 0}, 1.0, {0.5, 0, 0}));
  net.add_spring(first, second, net.add_material(damped(10.0, 0.1)));
  for (const double update : {newton, wavefront}) {
    INFO("update " << update);
    Simulation simulation = simulate(net, located(update, 1.0), 0.01);
    std::uint64_t sweeps = 0;
    for (int i = 0; i < 20; ++i) sweeps = std::max(sweeps, simulation.step().sweeps);
    CHECK(simulation.events().empty());
    CHECK(sweeps <= 8);  // the step is not divided
    CHECK(simulation.position(first)[0] == doctest::Approx(1.1).epsilon(1e-12));
  }
}
