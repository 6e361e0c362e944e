// Bodies that come to rest on their contacts, rebound until they lie, or have no room left, in the reference.

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <string>

#include <springnet/error.hpp>

#include "fate.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr Friction rough{Friction::Kind::coulomb, 0.4};

Network cube(double tilt, const Friction& friction, double restitution) {
  Network net;
  const Eigen::Matrix3d turn = Eigen::AngleAxis<double>(tilt, Vector3(1, 0.3, 0.2).normalized()).toRotationMatrix();
  for (int i = 0; i < 8; ++i)
    net.add_node(point(turn * Vector3(0.4 * (i & 1), 0.4 * ((i >> 1) & 1), 0.4 * (i >> 2)) + Vector3(0, 0, 0.6), 0.5,
                       {0.3, 0.1, 0}));
  for (NodeIndex i = 0; i < 8; ++i)
    for (NodeIndex j = i + 1; j < 8; ++j) net.add_rigid(i, j);
  net.set_gravity({0, 0, -9.81});
  Plane plane;
  plane.friction = friction;
  plane.restitution = restitution;
  net.add_plane(plane);
  return net;
}

// A floor, and a press that comes down on it from 0.5 m at 1 m/s.
void add_press(Network& net, const Friction& friction) {
  Plane floor;
  floor.name = "floor";
  floor.friction = friction;
  net.add_plane(floor);
  Plane press;
  press.name = "press";
  press.point = {0, 0, 0.5};
  press.normal = {0, 0, -1};
  press.friction = friction;
  press.motion.emplace();
  press.motion->interpolation = Motion::Interpolation::linear;
  press.motion->times = {0.0, 0.6};
  press.motion->displacements = {Vector3::Zero(), Vector3(0, 0, -0.6)};
  net.add_plane(press);
  net.set_gravity({0, 0, -9.81});
}

}  // namespace

// It rocked on its contacts 4e-7 s apart: 45,000 events, until the run stopped at 0.067 s.
TEST_CASE("a rigid tetrahedron comes to rest on a rough plane") {
  Network net;
  for (const Vector3& corner : {Vector3(0, 0, 0), Vector3(0.4, 0, 0), Vector3(0, 0.4, 0), Vector3(0, 0, 0.4)})
    net.add_node(point(corner, 1.0, {0.5, 0.3, 0}));
  for (NodeIndex i = 0; i < 4; ++i)
    for (NodeIndex j = i + 1; j < 4; ++j) net.add_rigid(i, j);
  net.set_gravity({0, 0, -9.81});
  Plane plane;
  plane.friction = {Friction::Kind::coulomb, 1.5};
  net.add_plane(plane);
  check_fate(net, 1.0);
  Simulation s = simulate(net, cvode(1e-9), 0.01);
  s.advance_to(1.0);
  for (NodeIndex k = 0; k < 4; ++k) CHECK(s.velocity(k).norm() <= 1e-12);
  CHECK((s.reaction(0) + s.reaction(1) + s.reaction(2) - Vector3(0, 0, 4 * 9.81)).norm() <= 1e-6);
}

// At the bottom of three slopes it changed from one to the next 7e-7 s apart: a million events in a second.
TEST_CASE("a node comes to rest where three rough planes meet") {
  Network net;
  net.add_node(point({0.01, 0, 0.3}, 1.0, {1, 0.3, 0}));
  net.set_gravity({0, 0, -9.81});
  for (const Vector3& normal : {Vector3(1, 0, 1), Vector3(-0.5, 0.866, 1), Vector3(-0.5, -0.866, 1)}) {
    Plane plane;
    plane.normal = normal;
    plane.friction = {Friction::Kind::coulomb, 0.2};
    net.add_plane(plane);
  }
  check_fate(net, 1.0);
  Simulation s = simulate(net, cvode(1e-7), 0.01);
  s.advance_to(1.0);
  CHECK(s.position(0).norm() <= 1e-9);  // ten times what a touch may be behind
  CHECK(s.velocity(0).norm() == 0.0);
}

// Each rebound began deeper behind the plane than the one before: up to a millimetre in the end.
TEST_CASE("a rigid cube rebounds from the plane itself until it lies") {
  for (const Friction& friction : {Friction{Friction::Kind::held, 0.0}, rough}) {
    for (const double tilt : {0.0, 0.4}) {
      CAPTURE(tilt);
      CAPTURE(friction.coefficient);
      const Network net = cube(tilt, friction, 0.5);
      for (const double tolerance : {1e-7, 1e-9}) {
        CAPTURE(tolerance);
        const Fate fate = tumble(net, tolerance, 1.5);
        CHECK(fate.gained <= 1e3 * tolerance * fate.scale);  // a thousand steps
        CHECK(fate.run.stretch <= 1.001e-8);
        CHECK(fate.run.sink <= 1e-7);
        CHECK(fate.run.pull <= 1e-6);
        // Speeds halve from 4 m/s to the least of a rebound, 4e-4 m/s: 14 times, on any of the eight nodes; each with
        // a touch and a release. Then it lies down.
        CHECK(fate.run.events.size() <= 256);
      }
      if (tilt > 0.0) continue;  // it still tips over an edge
      Simulation s = simulate(net, cvode(1e-7), 0.01);
      s.advance_to(1.5);
      for (NodeIndex k = 0; k < 8; ++k) CHECK(s.velocity(k).norm() <= 1e-12);
    }
  }
}

TEST_CASE("where obstacles leave no room the error names the time, the node and the obstacles") {
  for (const Friction& friction : {Friction{Friction::Kind::none, 0.0}, Friction{Friction::Kind::held, 0.0}, rough}) {
    for (const NodeIndex nodes : {1u, 2u}) {
      CAPTURE(static_cast<int>(friction.kind));
      CAPTURE(nodes);
      Network net;
      net.add_node(point({0, 0, 0.1}));
      if (nodes == 2) {
        net.add_node(point({0.01, 0, 0.3}));
        net.add_rigid(0, 1);
      }
      add_press(net, friction);
      Simulation s = simulate(net, cvode(1e-8), 1e-3);
      // A node has room until the press is down, a rod at least until that has come as far as it is long.
      s.advance_to(nodes == 1 ? 0.499 : 0.28);
      try {
        s.advance_to(0.51);
        FAIL_CHECK("it went on");
      } catch (const Error& error) {
        const std::string text = error.what();
        CAPTURE(text);
        CHECK(error.kind() == ErrorKind::simulation);
        CHECK(text.find("At 0.") != std::string::npos);
        // Of a rod, either end.
        const bool names_other = nodes == 2 && text.find("node 1") != std::string::npos;
        CHECK((names_other || text.find("node 0") != std::string::npos));
        CHECK(text.find("'floor'") != std::string::npos);
        CHECK(text.find("'press'") != std::string::npos);
      }
    }
  }
}

// Planes that close from both sides lift what slides up between them.
TEST_CASE("a node that obstacles close in on goes where it has room") {
  Network net;
  net.add_node(point({0, 0, 0.1}));
  net.set_gravity({0, 0, -9.81});
  const auto add = [&](double from, double side) {
    Plane plane;
    plane.point = {from, 0, 0};
    plane.normal = {side, 0, 0.5};
    plane.friction = {Friction::Kind::none, 0.0};
    plane.motion.emplace();
    plane.motion->interpolation = Motion::Interpolation::linear;
    plane.motion->times = {0.0, 0.6};
    plane.motion->displacements = {Vector3::Zero(), Vector3(side * 0.1, 0, 0)};
    net.add_plane(plane);
  };
  add(0.0, 1.0);
  add(0.3, -1.0);
  Simulation s = simulate(net, cvode(1e-8), 0.01);
  s.advance_to(0.55);
  // x = 0.15 between them; the left plane through (t / 6, 0, 0) with normal (1, 0, 1/2).
  CHECK((s.position(0) - Vector3(0.15, 0, -2.0 * (0.15 - 0.55 / 6.0))).norm() <= 1e-7);
}
