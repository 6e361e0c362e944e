// Rigid bodies that obstacles hold, and others push: they give way as far as the obstacles let them, and nothing passes
// through them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <springnet/error.hpp>

#include "rigid_bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double box_mass = 0.8, box_side = 0.2, ball_radius = 0.03, wall = 0.004;  // kg, m: half a thickness

// A ball that goes from `from` at this velocity, whatever resists.
NodeIndex add_pusher(Network& net, const Vector3& from, const Vector3& velocity) {
  const NodeIndex ball = add_ball(net, "pusher", from, Vector3::Zero(), 1.0, ball_radius);
  Move move;
  move.nodes = {ball};
  move.motion.times = {0.0, 10.0};
  move.motion.displacements = {Vector3::Zero(), 10.0 * velocity};
  move.motion.interpolation = Motion::Interpolation::linear;
  net.add_move(move);
  return ball;
}

double friction_of(const Simulation& s) { return s.surface_force(0)[0]; }

}  // namespace

// It pushes in the plane of the lower feet, so that the box neither turns nor tips: pusher and box go on together, the
// plane resists with mu m g.
TEST_CASE("a moved ball pushes a rigid box whose feet stick to the floor") {
  constexpr double mu = 0.5, pace = 0.1, start = 0.01;  // m/s, m: where it meets the box
  for (const Method& method : methods(1e-9)) {
    CAPTURE(method.name);
    Network net;
    add_box(net, "box", {0, 0, 0}, {box_side, box_side, box_side}, box_mass, wall);
    Plane floor;
    floor.friction = {Friction::Kind::coulomb, mu};
    net.add_plane(floor);
    const NodeIndex ball = add_pusher(net, {-wall - ball_radius - start, 0.5 * box_side, 0.04}, {pace, 0, 0});
    touch(net, 0, 1, frictionless);
    net.set_gravity({0, 0, -g});
    Simulation s = simulate(net, method.integrator, 0.002);
    s.advance_to(0.3);
    const double expected = -wall - ball_radius - start + pace * 0.3;
    CHECK(s.position(ball)[0] == doctest::Approx(expected));
    // In verlet the box goes on in small hops, as it meets the ball anew within each step; what friction takes within
    // one is what they may be.
    const double rubbed = method.name == "verlet" ? mu * g * 0.002 : 1e-7;  // m/s
    for (const NodeIndex k : {0u, 2u, 4u, 6u}) {
      CHECK(std::abs(s.position(k)[0] - expected - wall - ball_radius) <= 0.002 * rubbed + 1e-8);
      CHECK(std::abs(s.velocity(k)[0] - pace) <= rubbed);
    }
    // At theta 1/2 the force swings from step to step about its mean.
    const double before = friction_of(s);
    s.step();
    CHECK(0.5 * (before + friction_of(s)) == doctest::Approx(mu * box_mass * g).epsilon(1e-4));
  }
}

// Two bars carry the box, a ball rises between them and lifts it off both.
TEST_CASE("a moved ball lifts a rigid box off its supports") {
  constexpr double pace = 0.1, below = 0.01;
  for (const double mu : {0.0, 0.5}) {
    for (const Method& method : methods(1e-9)) {
      CAPTURE(mu);
      CAPTURE(method.name);
      Network net;
      add_box(net, "box", {0, 0, 0}, {box_side, box_side, box_side}, box_mass, wall);
      for (const double x : {0.0, box_side}) {
        Instrument bar;
        bar.name = x > 0.0 ? "right" : "left";
        bar.first = {x, -0.1, -0.01};
        bar.second = {x, 0.3, -0.01};
        bar.radius = 0.01;
        bar.friction = mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless;
        net.add_instrument(bar);
      }
      const NodeIndex ball =
          add_pusher(net, {0.5 * box_side, 0.5 * box_side, -wall - ball_radius - below}, {0, 0, pace});
      touch(net, 0, 1, frictionless);
      net.set_gravity({0, 0, -g});
      Simulation s = simulate(net, method.integrator, 0.002);
      s.advance_to(0.2);
      const double expected = -wall - ball_radius - below + pace * 0.2 + wall + ball_radius;
      for (NodeIndex k = 0; k < 4; ++k) CHECK(s.position(k)[2] == doctest::Approx(expected).epsilon(1e-6));
      CHECK(s.position(ball)[2] == doctest::Approx(expected - wall - ball_radius));
    }
  }
}

// Its path would lead through the board, on the other side of which it would be free.
TEST_CASE("a blow does not drive a rigid box through a thin board") {
  constexpr double thin = 0.002;
  Network net;
  add_box(net, "box", {0, 0, 0}, {box_side, box_side, box_side}, 0.4, wall);
  Instrument board;
  board.first = board.second = {0.5 * box_side, 0.5 * box_side, -0.5 * thin};
  board.box = BoxShape{{0.6, 0.6, thin}};
  board.friction = frictionless;
  net.add_instrument(board);
  add_ball(net, "ball", {0.5 * box_side, 0.5 * box_side, box_side + wall + ball_radius + 0.005}, {0, 0, -10.0}, 0.2,
           ball_radius);
  touch(net, 0, 1, frictionless, 1.0);
  net.set_gravity({0, 0, -g});
  Simulation s = simulate(net, verlet, 0.001);
  for (int i = 0; i < 200; ++i) {
    s.step();
    for (NodeIndex k = 0; k < 4; ++k) REQUIRE(s.position(k)[2] >= -1e-9);
  }
}

// It would have landed, but a ball lifts it within the same step: what the floor would have done does not happen.
TEST_CASE("a box that is struck as it would land keeps the momentum that the blow gives it") {
  Network net;
  add_box(net, "box", {0, 0, 0.0005}, {box_side, box_side, box_side}, box_mass, wall, {0, 0, -1.0});
  Plane floor;
  floor.friction = frictionless;
  net.add_plane(floor);
  add_ball(net, "ball", {0.5 * box_side, 0.5 * box_side, box_side - wall - ball_radius - 0.0002}, {0, 0, 10.0}, 2.0,
           ball_radius);
  touch(net, 0, 1, frictionless);
  Simulation s = simulate(net, verlet, 0.001);
  const Vector3 before = momentum(net, s);
  s.step();
  for (NodeIndex k = 0; k < 8; ++k) CHECK(s.velocity(k)[2] > 0.0);
  CHECK((momentum(net, s) - before).norm() <= 1e-9 * before.norm());
}

// Its corners touch the board with weights of fixed nodes alone then: there is nothing to settle.
TEST_CASE("corners of a rigid box are fixed while they touch a fixed board") {
  for (const Method& method : methods(1e-9)) {
    CAPTURE(method.name);
    Network net;
    add_sheet(net, "board", 3, 1.0, {0.1, 0.1, -2.0 * wall}, Vector3::UnitX(), Vector3::UnitY(), 2.0 * wall, 1.0, true);
    const std::size_t box = add_box(net, "box", {0.013, 0.007, 0}, {box_side, box_side, box_side}, box_mass, wall);
    touch(net, 0, box, frictionless);
    net.set_gravity({0, 0, -g});
    Simulation s = simulate(net, method.integrator, 0.002);
    advance(s, 10);
    const NodeIndex first = net.bodies()[box].first_node;
    for (const NodeIndex corner : {0u, 3u}) {
      s.set_fixed(first + corner, true);
      advance(s, 10);
      for (NodeIndex k = first; k < first + 8; ++k) {
        CHECK(s.velocity(k).norm() <= 1e-6);
        CHECK((s.position(k) - net.nodes()[k].position).norm() <= 1e-6);
      }
    }
  }
}

// A ball that goes on down, onto a grain, or a box, that lies on the floor.
TEST_CASE("what has no place left between a moved body and the floor is an error") {
  for (const bool is_box : {false, true}) {
    for (const Method& method : methods(1e-6)) {
      CAPTURE(is_box);
      CAPTURE(method.name);
      Network net;
      if (is_box)
        add_box(net, "box", {-0.1, -0.1, 0}, {box_side, box_side, box_side}, box_mass, wall);
      else
        add_ball(net, "grain", {0, 0, 0}, at_rest, 0.1, wall);
      Plane floor;
      floor.friction = frictionless;
      net.add_plane(floor);
      add_pusher(net, {0, 0, (is_box ? box_side : 0.0) + wall + ball_radius + 0.01}, {0, 0, -1.0});
      touch(net, 0, 1, frictionless);
      net.set_gravity({0, 0, -g});
      Simulation s = simulate(net, method.integrator, 0.002);
      CHECK_THROWS_AS(s.advance_to(0.2), Error);
      CHECK(s.time() >= 0.008);
      CHECK(s.time() <= 0.05);
    }
  }
}
