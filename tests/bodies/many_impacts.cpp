// Many impacts in one step, which have to happen in the order of time.

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <springnet/events.hpp>
#include <springnet/simulation.hpp>

#include "bodies.hpp"
#include "crossings.hpp"
#include "rigid_bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double r = 0.01;                                           // m
const std::vector<double> places{0.0, 0.05, 0.13, 0.17, 0.29};       // m
const std::vector<double> speeds{1.03, -2.07, 4.11, -9.05, -12.13};  // m/s

Network balls_in_a_line(const std::vector<double>& x, const std::vector<double>& v, double restitution,
                        bool first_is_fixed) {
  Network net;
  for (std::size_t i = 0; i < x.size(); ++i)
    add_ball(net, std::to_string(i), {x[i], 0, 0}, {v[i], 0, 0}, 0.3, r, first_is_fixed && i == 0);
  touch_all(net, frictionless, restitution);
  return net;
}

// Equal balls exchange their velocities, so that without their thickness each velocity goes on as if alone.
void check_elastic(const std::vector<double>& x, const std::vector<double>& v, double h, int steps) {
  CAPTURE(h);
  const Network net = balls_in_a_line(x, v, 1.0, false);
  Simulation s = simulate(net, verlet, h);
  for (int step = 0; step < steps; ++step) {
    CHECK(s.step().substeps == 0);  // found without dividing the step
    std::vector<std::pair<double, double>> free;
    for (std::size_t i = 0; i < x.size(); ++i)
      free.emplace_back(x[i] - 2.0 * r * static_cast<double>(i) + v[i] * s.time(), v[i]);
    std::sort(free.begin(), free.end());
    for (NodeIndex i = 0; i < x.size(); ++i) {
      CAPTURE(i);
      // Ten meetings, each to the accuracy of gaps, 1e-9 of the thickness, at 20 m/s.
      CHECK(std::abs(s.position(i)[0] - 2.0 * r * i - free[i].first) < 1e-8);
      CHECK(std::abs(s.velocity(i)[0] - free[i].second) < 1e-6);
    }
  }
}

}  // namespace

TEST_CASE("elastic balls in a line meet in the order of time, however many within a step of verlet") {
  check_elastic(places, speeds, 0.02, 2);
  check_elastic(places, speeds, 0.01, 4);
  check_elastic(places, speeds, 0.001, 40);
}

// Nearer than the search for meetings tells from touching, and not as near.
TEST_CASE("what an impact drives into a ball a hair's breadth away strikes that one") {
  for (const double gap : {1e-9, 1e-7, 1e-6, 5e-6, 1e-4}) {
    CAPTURE(gap);
    check_elastic({0.0, 0.05, 0.05 + 2.0 * r + gap}, {10.0, 0.0, 0.0}, 0.01, 1);
  }
}

// Sixty pairs, each at another time.
TEST_CASE("impacts far from each other keep their restitution, however many in a step") {
  Network net;
  std::vector<double> speed;
  for (int i = 0; i < 60; ++i) {
    speed.push_back(2.0 + 0.03 * i);
    add_ball(net, "a" + std::to_string(i), {0, 0.2 * i, 0}, {speed.back(), 0, 0}, 0.3, r);
    add_ball(net, "b" + std::to_string(i), {0.05, 0.2 * i, 0}, {-speed.back(), 0, 0}, 0.3, r);
  }
  touch_all(net, frictionless, 1.0);
  Simulation s = simulate(net, verlet, 0.01);
  s.step();
  for (NodeIndex i = 0; i < 60; ++i) {
    CAPTURE(i);
    CHECK(std::abs(s.velocity(2 * i)[0] + speed[i]) < 1e-6);
    CHECK(std::abs(s.velocity(2 * i + 1)[0] - speed[i]) < 1e-6);
  }
}

TEST_CASE("balls that fall onto each other within a step stop where the one below has stopped") {
  const Network net = balls_in_a_line(places, speeds, 0.0, true);
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
  struct Pile {
    int boxes;
    double speed;  // m/s, at which neighbours approach each other
  };
  for (const auto& [boxes, speed] : {Pile{5, 3.0}, Pile{3, 5.0}})
    for (const auto& [h, mu] : {std::pair(0.01, 0.0), std::pair(0.01, 0.5), std::pair(0.005, 0.0),
                                std::pair(0.005, 0.5), std::pair(0.002, 0.0), std::pair(0.002, 0.5)}) {
      CAPTURE(boxes);
      CAPTURE(h);
      CAPTURE(mu);
      const Friction friction = mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless;
      Network net;
      for (int i = 0; i < boxes; ++i)
        add_box(net, std::to_string(i), {0.007 * (i % 4), 0.011 * (i % 3), 0.002 + 0.3 * i}, Vector3::Constant(side),
                mass, 0.5 * thickness, {0, 0, -speed * i});
      // What falls beside them has the events of one step once, also where that is divided.
      for (int i = 0; i < 8; ++i)
        add_ball(net, "ball " + std::to_string(i), {1.0 + 0.3 * i, 0, 0.05 * i}, at_rest, 0.1, r);
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
          energy += net.nodes()[k].mass * (0.5 * s.velocity(k).squaredNorm() + g * s.position(k)[2]);
          lowest = std::min(lowest, s.position(k)[2]);
        }
        CHECK(lowest > -1e-6);
        // What overlaps by up to a thousandth of the thickness is pushed apart in the next step, however short.
        CHECK(energy < before + 0.05);
        before = energy;
      }
      double last = 0.0;
      std::map<NodeIndex, bool> touches;
      for (const Event& event : s.events()) {
        CHECK(event.time >= last - h);  // those of bodies are of the ends of steps
        last = std::max(last, event.time);
        if (event.kind != Event::Kind::touched && event.kind != Event::Kind::released) continue;
        const bool now = event.kind == Event::Kind::touched;
        CHECK(touches[event.index] != now);
        touches[event.index] = now;
      }
    }
}
