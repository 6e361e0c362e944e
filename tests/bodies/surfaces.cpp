// Surfaces: nothing passes through, bodies that meet keep momentum, and what never touches keeps its bits.

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <springnet/events.hpp>

#include "bodies.hpp"
#include "crossings.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("a node that is fired at a sheet at a hundred thicknesses a step does not pass") {
  const double thickness = 0.002, h = 0.01, speed = 100.0 * thickness / h;
  for (const bool fixed : {true, false}) {
    for (const Vector3& direction : {Vector3(0, 0, -1), Vector3(0.3, -0.5, -1.0), Vector3(1.0, 0.2, -0.1)}) {
      CAPTURE(fixed);
      CAPTURE(direction.transpose());
      Network net;
      const std::size_t sheet = add_sheet(net, "sheet", 7, 0.6, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(),
                                          thickness, 0.01, fixed, 2000.0);
      const Vector3 v = speed * direction.normalized();
      const NodeIndex ball = add_ball(net, "ball", -3.37 * h * v + Vector3(0.02, 0.03, 0), v, 0.005, 0.001);
      touch(net, sheet, net.bodies().size() - 1, frictionless);
      Simulation s = simulate(net, verlet, h / (fixed ? 1.0 : 20.0));
      const Vector3 p = momentum(net, s), l = angular_momentum(net, s);
      advance(s, fixed ? 8 : 160);
      REQUIRE(!s.events().empty());
      if (fixed) {
        CHECK(s.position(ball)[2] >= 0.002 - 1e-8);
        // Where it slides onto the next face, that is met at the root of the rounding before its border: 1e-8 of 20
        // m/s.
        CHECK((s.velocity(ball) - Vector3(v[0], v[1], 0)).norm() <= 1e-6);
      } else {
        CHECK((momentum(net, s) - p).norm() <= 1e-13);
        // Each impact keeps it; where one bends the path to another of the same step, that is where it would have been
        // to the share of both in the step: 1e-5 of what the ball brings.
        CHECK((angular_momentum(net, s) - l).norm() <= 1e-5 * l.norm() + 1e-6 * p.norm());
        CHECK(count_crossings(net, s) == 0);
      }
    }
  }
}

TEST_CASE("blocks that meet keep momentum and angular momentum, and do not enter each other") {
  for (const double mu : {0.0, 0.4}) {
    CAPTURE(mu);
    Network net;
    add_block(net, "left", 3, 0.1, {-0.35, 0.03, 0.02}, {1.5, 0, 0.1}, 0.02, 0.01, 300.0, 0.05);
    add_block(net, "right", 4, 0.08, {0.0, 0.0, 0.0}, {-0.5, 0.2, 0}, 0.02, 0.006, 300.0, 0.05);
    touch(net, 0, 1, {Friction::Kind::coulomb, mu}, 0.3);
    Simulation s = simulate(net, verlet, 0.001);
    const Vector3 p = momentum(net, s), l = angular_momentum(net, s);
    bool met = false;
    for (int i = 0; i < 400; ++i) {
      s.step();
      met = met || !s.body_touches().empty();
      if (i % 10 == 0) REQUIRE(count_crossings(net, s) == 0);
    }
    CHECK(met);
    CHECK(count_events(s).met > 0);
    // Damping is axial and so keeps both; rounding of 400 steps.
    CHECK((momentum(net, s) - p).norm() <= 1e-13);
    // As above; and nodes have no spin that could take the moment of friction across the thickness, 0.02 m.
    const double size = l.norm() + 0.1 * p.norm();
    CHECK((angular_momentum(net, s) - l).norm() <= (mu > 0.0 ? 0.02 * mu * p.norm() : 1e-5 * size));
  }
}

TEST_CASE("what never touches moves in the same bits as without contact") {
  Network net;
  add_block(net, "left", 4, 0.1, {-1.35, 0.03, 0.02}, {0.3, 0, 0.1}, 0.02, 0.01, 300.0, 0.05);
  add_block(net, "right", 4, 0.08, {0.0, 0.0, 0.3}, {-0.5, 0.2, 0}, 0.02, 0.006, 300.0, 0.05);
  net.set_gravity({0, 0, -9.81});
  Plane floor;
  floor.friction = {Friction::Kind::coulomb, 0.2};
  floor.point = {0, 0, -0.1};
  net.add_plane(floor);
  Network with = net;
  touch_all(with, {Friction::Kind::coulomb, 0.2}, 0.5);
  Simulation a = simulate(net, verlet, 0.001), b = simulate(with, verlet, 0.001);
  for (int i = 0; i < 400; ++i) {
    a.step();
    b.step();
    REQUIRE(a.positions() == b.positions());
    REQUIRE(a.velocities() == b.velocities());
  }
  CHECK(!a.events().empty());  // of the floor
}

TEST_CASE("contact of bodies has the same bits for every number of threads, and after a saved state") {
  Network net;
  add_block(net, "left", 5, 0.1, {-0.45, 0.03, 0.02}, {1.5, 0, 0.1}, 0.02, 0.01, 300.0, 0.05);
  add_block(net, "right", 5, 0.08, {0.0, 0.0, 0.0}, {-0.5, 0.2, 0}, 0.02, 0.006, 300.0, 0.05);
  touch(net, 0, 1, {Friction::Kind::coulomb, 0.3});
  check_bits(net, verlet, 0.001, 60, 60);
}
