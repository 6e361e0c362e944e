// Surfaces that close until there is no place left between them.

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Motion along(const Vector3& velocity, double until) {
  Motion motion;
  motion.interpolation = Motion::Interpolation::linear;
  motion.times = {0.0, until};
  motion.displacements = {Vector3::Zero(), until * velocity};
  return motion;
}

// A plane that moves towards its free side.
Plane advancing(const char* name, const Vector3& where, const Vector3& normal, double speed, const Friction& friction,
                double until = 10.0) {
  Plane plane;
  plane.name = name;
  plane.point = where;
  plane.normal = normal;
  plane.friction = friction;
  plane.motion = along(speed * normal.normalized(), until);
  return plane;
}

// Three planes around the z axis, at 0.1 m.
Network prism(const Friction& friction) {
  Network net;
  net.add_node(point({0.02, 0, 0.01}));
  const char* const names[] = {"a", "b", "c"};
  for (const int i : {0, 1, 2}) {
    const Vector3 n(std::cos(2.0 * std::numbers::pi * i / 3.0), std::sin(2.0 * std::numbers::pi * i / 3.0), 0.0);
    net.add_plane(advancing(names[i], -0.1 * n, n, 0.5, friction));
  }
  return net;
}

Network press(const Friction& friction, double until = 10.0) {
  Network net;
  net.add_node(point({0.02, 0, 0}));
  net.add_plane(advancing("left", {-0.1, 0, 0}, {1, 0, 0}, 0.5, friction, until));
  net.add_plane(advancing("right", {0.1, 0, 0}, {-1, 0, 0}, 0.3, friction, until));
  return net;
}

// A ball that comes down on a node that lies on the floor.
Network mortar(const Friction& friction, double beside) {
  Network net;
  net.add_node(point({beside, 0, 0}));
  Instrument ball;
  ball.name = "ball";
  ball.first = ball.second = {0, 0, 1.1};
  ball.friction = friction;
  ball.motion = along({0, 0, -0.5}, 10.0);
  net.add_instrument(ball);
  Plane floor;
  floor.name = "floor";
  floor.friction = friction;
  net.add_plane(floor);
  return net;
}

std::string end_of(Simulation& s, double until) {
  try {
    s.advance_to(until);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("obstacles that close on a node end the run with its name and theirs, and results so far are kept") {
  constexpr double h = 0.005;
  const Friction frictions[] = {frictionless, {Friction::Kind::coulomb, 0.3}, {Friction::Kind::held, 0.0}};
  for (const Friction& friction : frictions) {
    struct Example {
      Network net;
      double closes;  // s
      std::vector<const char*> names;
    };
    const Example examples[] = {{press(friction), 0.25, {"'left'", "'right'"}},
                                {prism(friction), 0.2, {"'a'", "'b'", "'c'"}},
                                {mortar(friction, 0.0), 0.2, {"'floor'", "'ball'"}}};
    for (const Example& example : examples) {
      for (const Scheme& scheme : all_schemes(1e-9)) {
        INFO(scheme.name << ", friction " << static_cast<int>(friction.kind) << ", " << example.names[0]);
        Simulation s = simulate(example.net, scheme.integrator, h);
        const std::string text = end_of(s, 2.0 * example.closes);
        CHECK(text.find("node 0") != std::string::npos);
        for (const char* name : example.names) CHECK(text.find(name) != std::string::npos);
        // Where one of three planes lets the node go, the node may be behind it for a step.
        CHECK(s.time() >= example.closes - 2.0 * h);
        CHECK(s.time() <= example.closes + 4.0 * h);
        CHECK(s.position(0).allFinite());
      }
    }
  }
}

TEST_CASE("obstacles that stop before they close, or let a node escape, do not end the run") {
  constexpr double h = 0.005;
  for (const Scheme& scheme : all_schemes(1e-9)) {
    INFO(scheme.name);
    Simulation stopped = simulate(press(frictionless, 0.2499), scheme.integrator, h);
    CHECK(end_of(stopped, 0.4) == "");
    CHECK(std::abs(stopped.position(0).x() - 0.025) <= 1e-3);
    // The ball meets the floor at 0.2 s, in the middle.
    Simulation beside = simulate(mortar(frictionless, 0.2), scheme.integrator, h);
    CHECK(end_of(beside, 0.25) == "");
    CHECK(beside.position(0).x() > 0.2);
  }
}

// The step that ends where the rod touches settles without the touch.
TEST_CASE("a rod that slides between planes that close is divided where it touches, and goes on") {
  constexpr double speed = 0.2, until = 0.4;
  Network net;
  net.add_node(point({-0.09, 0, 0}));
  net.add_node(point({0.09, 0, 0.01}, 3.0));
  net.add_rigid(0, 1);
  net.add_plane(advancing("left", {-0.1, 0, 0}, {1, 0, 0}, speed, frictionless));
  net.add_plane(advancing("right", {0.1, 0, 0}, {-1, 0, 0}, speed, frictionless));
  for (const double theta : {1.0, 0.5}) {
    for (const double rule : {newton, block}) {
      INFO("theta " << theta << ", rule " << rule);
      Simulation s = simulate(net, recurrent(rule, 1e-11, {{"theta", theta}, {"events", 1.0}}), 0.005);
      CHECK(end_of(s, until) == "");
      CHECK(worst_length(net, s) <= 1e-9);
      for (const NodeIndex k : {0u, 1u}) CHECK(std::abs(s.position(k).x()) <= 0.1 - speed * until + 1e-9);
    }
  }
}
