// Many impacts in one step, which have to happen in the order of time.

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <springnet/simulation.hpp>

#include "bodies.hpp"
#include "crossings.hpp"
#include "rigid_bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double r = 0.01;  // m
constexpr std::array<double, 5> places{0.0, 0.05, 0.13, 0.17, 0.29},
    speeds{1.03, -2.07, 4.11, -9.05, -12.13};  // m, m/s

Network balls_in_a_line(double restitution, bool first_is_fixed) {
  Network net;
  for (std::size_t i = 0; i < places.size(); ++i)
    add_ball(net, std::to_string(i), {places[i], 0, 0}, {speeds[i], 0, 0}, 0.3, r, first_is_fixed && i == 0);
  touch_all(net, frictionless, restitution);
  return net;
}

}  // namespace

// Equal balls exchange their velocities, so that without their thickness each velocity goes on as if alone.
TEST_CASE("elastic balls in a line meet in the order of time, however many within a step of verlet") {
  const Network net = balls_in_a_line(1.0, false);
  for (const double h : {0.02, 0.01, 0.001}) {
    CAPTURE(h);
    Simulation s = simulate(net, verlet, h);
    for (int step = 1; step * h < 0.0401; ++step) {
      s.step();
      std::vector<std::pair<double, double>> free;
      for (std::size_t i = 0; i < places.size(); ++i)
        free.emplace_back(places[i] - 2.0 * r * static_cast<double>(i) + speeds[i] * s.time(), speeds[i]);
      std::sort(free.begin(), free.end());
      for (NodeIndex i = 0; i < places.size(); ++i) {
        CAPTURE(i);
        // Ten meetings, each to the accuracy of gaps, 1e-9 of the thickness, at 20 m/s.
        CHECK(std::abs(s.position(i)[0] - 2.0 * r * i - free[i].first) < 1e-8);
        CHECK(std::abs(s.velocity(i)[0] - free[i].second) < 1e-6);
      }
    }
  }
}

TEST_CASE("balls that fall onto each other within a step stop where the one below has stopped") {
  const Network net = balls_in_a_line(0.0, true);
  for (const double h : {0.05, 0.025}) {
    CAPTURE(h);
    Simulation s = simulate(net, verlet, h);
    advance(s, h > 0.03 ? 2 : 4);
    double speed = 0.0;  // of the four together, which end on the first, or go away from it
    for (NodeIndex i = 1; i < places.size(); ++i) speed += 0.25 * s.velocity(i)[0];
    CHECK(std::abs(speed) < 1e-9);
    for (NodeIndex i = 0; i < places.size(); ++i) CHECK(std::abs(s.position(i)[0] - 2.0 * r * i) < 1e-8);
  }
}

TEST_CASE("rigid boxes that fall onto each other at several thicknesses a step do not enter each other in verlet") {
  constexpr double side = 0.2, mass = 0.4, thickness = 0.006;
  for (const double h : {0.01, 0.005, 0.002})
    for (const double mu : {0.0, 0.5}) {
      CAPTURE(h);
      CAPTURE(mu);
      const Friction friction = mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless;
      Network net;
      for (int i = 0; i < 5; ++i)
        add_box(net, std::to_string(i), {0.007 * (i % 4), 0.011 * (i % 3), 0.002 + 0.3 * i}, Vector3::Constant(side),
                mass, 0.5 * thickness, {0, 0, -3.0 * i});
      touch_all(net, friction);
      Plane floor;
      floor.friction = friction;
      net.add_plane(floor);
      net.set_gravity({0, 0, -g});
      Simulation s = simulate(net, verlet, h);
      double before = 1e9;
      while (s.time() < 0.3) {
        s.step();
        REQUIRE(count_crossings(net, s) == 0);
        double energy = 0.0, lowest = 0.0;
        for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
          energy += mass / 8.0 * (0.5 * s.velocity(k).squaredNorm() + g * s.position(k)[2]);
          lowest = std::min(lowest, s.position(k)[2]);
        }
        CHECK(lowest > -1e-6);
        // What overlaps by up to a hundredth of the thickness is pushed apart in the next step.
        CHECK(energy < before + 0.1);
        before = energy;
      }
    }
}
