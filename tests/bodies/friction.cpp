// Friction of bodies on each other: on an incline, and on a body that moves.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <springnet/events.hpp>

#include "bodies.hpp"
#include "rigid_bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// A ball on a fixed sheet that is inclined about y by this angle.
Network on_incline(double angle, const Friction& friction) {
  Network net;
  const Vector3 down(std::cos(angle), 0, -std::sin(angle)), up(std::sin(angle), 0, std::cos(angle));
  add_sheet(net, "incline", 21, 4.0, {0, 0, 0}, down, Vector3::UnitY(), 0.02, 1.0, true);
  add_ball(net, "ball", -1.5 * down + 0.06 * up + Vector3(0, 0.013, 0), at_rest, 0.3, 0.05);
  touch(net, 0, 1, friction);
  net.set_gravity({0, 0, -g});
  return net;
}

}  // namespace

TEST_CASE("a ball on an inclined sheet sticks below the angle of friction, and slides above it") {
  const double mu = 0.5, time = 0.6;
  for (const double angle : {0.2, std::atan(mu) - 1e-3, std::atan(mu) + 1e-3, 0.7}) {
    CAPTURE(angle);
    const Vector3 down(std::cos(angle), 0, -std::sin(angle));
    Simulation s = simulate(on_incline(angle, {Friction::Kind::coulomb, mu}), verlet, 0.002);
    const NodeIndex ball = static_cast<NodeIndex>(s.columns().size() - 1);
    const Vector3 start = s.position(ball);
    advance(s, 300);
    const double a = std::max(0.0, g * (std::sin(angle) - mu * std::cos(angle)));
    // Constant forces: exact but for the tolerance of gaps, 1e-8 of a length, in each of 300 steps.
    CHECK((s.position(ball) - start - 0.5 * a * time * time * down).norm() <= 1e-5);
    CHECK((s.velocity(ball) - a * time * down).norm() <= 1e-5);
    REQUIRE(!s.body_touches().empty());
    Vector3 force = Vector3::Zero();
    for (const BodyTouch& each : s.body_touches()) force += (each.nodes[0] == ball ? 1.0 : -1.0) * each.force;
    CHECK((force - 0.3 * (Vector3(0, 0, g) + a * down)).norm() <= 1e-4);
  }
}

TEST_CASE("a held ball stays where it touched; a frictionless one slides as on ice") {
  const double angle = 0.6, time = 0.4;
  const Vector3 down(std::cos(angle), 0, -std::sin(angle));
  for (const Friction& friction : {Friction{}, frictionless}) {
    Simulation s = simulate(on_incline(angle, friction), verlet, 0.002);
    const NodeIndex ball = static_cast<NodeIndex>(s.columns().size() - 1);
    const Vector3 start = s.position(ball);
    advance(s, 200);
    const double a = friction.kind == Friction::Kind::held ? 0.0 : g * std::sin(angle);
    CHECK((s.position(ball) - start - 0.5 * a * time * time * down).norm() <= 1e-5);
  }
}

TEST_CASE("a block that is thrown along another one stops where friction stops it") {
  const double mu = 0.3, speed = 0.4;
  Network net;
  add_block(net, "low", 5, 0.1, {0, 0, 0}, at_rest, 0.05, 0.01, 20000.0, 10.0);
  for (NodeIndex k = 0; k < 125; ++k) net.fix(k);
  add_block(net, "high", 3, 0.1, {0.03, 0.12, 0.41}, {speed, 0, 0}, 0.05, 0.01, 20000.0, 10.0);
  touch(net, 0, 1, {Friction::Kind::coulomb, mu});
  net.set_gravity({0, 0, -g});
  Simulation s = simulate(net, verlet, 0.0002);
  const auto mean = [&](const auto& of) {
    Vector3 sum = Vector3::Zero();
    for (NodeIndex k = 125; k < 152; ++k) sum += of(k) / 27.0;
    return sum;
  };
  const auto place = [&](NodeIndex k) { return s.position(k); };
  const auto velocity = [&](NodeIndex k) { return s.velocity(k); };
  const double start = mean(place)[0], slows = mu * g;
  advance(s, 400);
  // It rocks a little, as friction is below its middle, and so presses on the other body by turns.
  CHECK(mean(velocity)[0] == doctest::Approx(speed - slows * 0.08).epsilon(0.03));
  advance(s, 3000);
  CHECK(mean(place)[0] - start == doctest::Approx(0.5 * speed * speed / slows).epsilon(0.03));
  CHECK(mean(velocity).norm() <= 1e-3);
}

// Below the angle of friction of both, above that of the upper pair, above that of the lower pair only: both go as one.
TEST_CASE("a rigid block on a rigid block on an incline slides above the angle of friction between them") {
  constexpr double time = 0.1, mass = 0.8, h = 0.002, apart = 2e-3;
  struct Case {
    double upper, lower, angle;
  };
  for (const Method& method : methods(1e-8)) {
    CAPTURE(method.name);
    for (const auto& [upper, lower, angle] :
         {Case{0.3, 0.8, std::atan(0.3) - apart}, Case{0.3, 0.8, std::atan(0.3) + apart}, Case{0.3, 0.8, 0.4},
          Case{0.8, 0.3, std::atan(0.3) - apart}, Case{0.8, 0.3, 0.4}}) {
      CAPTURE(upper);
      CAPTURE(lower);
      CAPTURE(angle);
      Network net;
      add_sheet(net, "incline", 5, 2.0, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(), 0.02, 1.0, true);
      // Flat, so that none tips over; within the one below.
      add_box(net, "lower", {-0.31, -0.23, 0.02}, {0.5, 0.4, 0.06}, mass, 0.01);
      add_box(net, "upper", {-0.22, -0.17, 0.10}, {0.3, 0.25, 0.06}, mass, 0.01);
      touch(net, 0, 1, {Friction::Kind::coulomb, lower});
      touch(net, 1, 2, {Friction::Kind::coulomb, upper});
      net.set_gravity(g * Vector3(std::sin(angle), 0, -std::cos(angle)));
      Simulation s = simulate(net, method.integrator, h);
      advance(s, 50);
      const auto slides_at = [&](double mu) { return std::max(0.0, g * (std::sin(angle) - mu * std::cos(angle))); };
      // Where the upper pair holds, both have the acceleration of the lower one.
      const double a_lower = upper > lower ? slides_at(lower) : 0.0,
                   a_upper = upper > lower ? a_lower : slides_at(upper);
      for (const auto& [body, a] : {std::pair(1u, a_lower), std::pair(2u, a_upper)}) {
        CAPTURE(body);
        const double path = 0.5 * a * time * (time + (2.0 * method.theta - 1.0) * h);
        const NodeIndex first = net.bodies()[body].first_node;
        for (NodeIndex k = first; k < first + 8; ++k) {
          CHECK((s.position(k) - net.nodes()[k].position - path * Vector3::UnitX()).norm() <= 1e-5);
          CHECK((s.velocity(k) - a * time * Vector3::UnitX()).norm() <= 2e-4);
        }
      }
    }
  }
}

// Of the upper one: the mean forces of pairs that touch at the end of a step, and the impulses of the events of others.
TEST_CASE("forces of pairs and impulses of events together are what a body gets in each step") {
  constexpr double h = 0.001;
  for (const LawUse& integrator : {verlet, recurrent(newton, 1e-8)}) {
    CAPTURE(integrator.id);
    Network net;
    add_block(net, "lower", 3, 0.05, {0, 0, 0}, at_rest, 0.01, 0.01, 500.0, 0.5);
    add_block(net, "upper", 3, 0.04, {0.01, 0.013, 0.111}, {0.4, 0, 0}, 0.01, 0.01, 500.0, 0.5);
    for (NodeIndex k = 0; k < 9; ++k) net.fix(k);
    touch(net, 0, 1, {Friction::Kind::coulomb, 0.3});
    net.set_gravity({0, 0, -g});
    const NodeIndex first = net.bodies()[1].first_node;
    Simulation s = simulate(net, integrator, h);
    const auto momentum_above = [&] {
      Vector3 sum = Vector3::Zero();
      for (NodeIndex k = first; k < net.nodes().size(); ++k) sum += net.nodes()[k].mass * s.velocity(k);
      return sum;
    };
    Vector3 before = momentum_above();
    std::size_t seen = 0, parted = 0;
    for (int i = 0; i < 150; ++i) {
      s.step();
      Vector3 given = 27 * 0.01 * h * net.gravity();
      const auto is_first = [&](NodeIndex node) { return node >= first ? 1.0 : -1.0; };
      for (const BodyTouch& each : s.body_touches()) given += h * is_first(each.nodes[0]) * each.force;
      for (; seen < s.events().size(); ++seen) {
        const Event& event = s.events()[seen];
        const std::vector<BodyTouch> touches = s.body_touches();
        const bool touches_still = std::any_of(touches.begin(), touches.end(),
                                               [&](const BodyTouch& each) { return each.nodes == event.pair; });
        if (!touches_still) given += is_first(event.pair[0]) * event.impulse;
        parted += event.kind == Event::Kind::parted && event.impulse.norm() > 1e-9 ? 1 : 0;
      }
      const Vector3 now = momentum_above();
      CHECK((now - before - given).norm() < 1e-9);  // 3e-3 N s a step; network: forces to 1e-8 N
      before = now;
    }
    if (integrator.id == "verlet") CHECK(parted > 0);
  }
}
