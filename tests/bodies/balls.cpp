// Balls: impacts of two, of many in a row, at rest on each other.

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include <springnet/events.hpp>

#include "bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("two balls in a line exchange what Newton's law of impact says") {
  const double m = 2.0, n = 0.7, gap = 0.9, speed = 1.3;
  for (const double e : {0.0, 0.4, 1.0}) {
    CAPTURE(e);
    Network net;
    add_ball(net, "a", {0, 0, 0}, {speed, 0, 0}, m, 0.1);
    add_ball(net, "b", {gap + 0.35, 0, 0}, at_rest, n, 0.25);
    touch_all(net, frictionless, e);
    Simulation s = simulate(net, verlet, 0.01);
    advance(s, 200);
    // J = (1 + e) m n / (m + n) v, at gap / v.
    const double impulse = (1.0 + e) * m * n / (m + n) * speed, met = gap / speed, rest = 2.0 - met;
    const double first = speed - impulse / m, second = impulse / n;
    // Free flight is exact; the time of the meeting is found by Newton's method, to rounding.
    CHECK(s.velocity(0)[0] == doctest::Approx(first).epsilon(1e-12));
    CHECK(s.velocity(1)[0] == doctest::Approx(second).epsilon(1e-12));
    CHECK(s.position(0)[0] == doctest::Approx(gap + rest * first).epsilon(1e-11));
    CHECK(s.position(1)[0] == doctest::Approx(gap + 0.35 + rest * second).epsilon(1e-11));
    REQUIRE(s.events().size() >= 1);
    const Event& event = s.events().front();
    CHECK(event.kind == Event::Kind::met);
    CHECK(event.pair_first == 1);
    CHECK(event.pair_count == 2);
    CHECK(std::abs(event.impulse[0]) == doctest::Approx(impulse).epsilon(1e-12));
  }
}

TEST_CASE("two balls that meet at an angle keep momentum, angular momentum and their slip") {
  const double radius = 0.2, offset = 0.15;
  Network net;
  add_ball(net, "a", {-1, offset, 0.05}, {2, 0, 0}, 1.5, radius);
  add_ball(net, "b", {0.4, 0, 0}, {-1, 0.2, 0}, 0.8, radius);
  touch_all(net, frictionless, 0.6);
  Simulation s = simulate(net, verlet, 0.013);
  const Vector3 p = momentum(net, s), l = angular_momentum(net, s);
  const Vector3 before = s.velocity(0) - s.velocity(1);
  advance(s, 100);
  CHECK((momentum(net, s) - p).norm() <= 1e-14 * 5.0);
  CHECK((angular_momentum(net, s) - l).norm() <= 1e-13);
  REQUIRE(!s.events().empty());
  const Vector3 n = s.events().front().normal, after = s.velocity(0) - s.velocity(1);
  CHECK(n.dot(after) == doctest::Approx(-0.6 * n.dot(before)).epsilon(1e-12));
  CHECK((after - n * n.dot(after) - before + n * n.dot(before)).norm() <= 1e-13);
  // Where the line between both is as long as the radii: |d + w t| = 2 r.
  const Vector3 d = Vector3(-1, offset, 0.05) - Vector3(0.4, 0, 0);
  const double a = before.squaredNorm(), b = d.dot(before), c = d.squaredNorm() - 4.0 * radius * radius;
  const double time = (-b - std::sqrt(b * b - a * c)) / a;
  CHECK((n - (d + time * before) / (2.0 * radius)).norm() <= 1e-12);
}

TEST_CASE("friction of balls that meet lies in Coulomb's cone, and ends the slip if it can") {
  const double m = 1.0, n = 3.0;
  for (const double mu : {0.1, 5.0}) {
    CAPTURE(mu);
    Network net;
    add_ball(net, "a", {-0.5, 0.0, 0.0}, {2, 0.3, 0}, m, 0.1);
    add_ball(net, "b", {0.3, 0.1, 0}, {0, 0, 0}, n, 0.1);
    touch_all(net, {Friction::Kind::coulomb, mu});
    Simulation s = simulate(net, verlet, 0.01);
    const Vector3 p = momentum(net, s), l = angular_momentum(net, s), before = s.velocity(0) - s.velocity(1);
    while (s.events().empty()) s.step();
    const Event event = s.events().front();
    const Vector3 along = event.normal * event.normal.dot(event.impulse), across = event.impulse - along;
    const Vector3 slip = before - event.normal * event.normal.dot(before);
    const double reduced = m * n / (m + n), needed = reduced * slip.norm();
    CHECK(along.norm() == doctest::Approx(-reduced * event.normal.dot(before)).epsilon(1e-9));
    CHECK(across.norm() == doctest::Approx(std::min(mu * along.norm(), needed)).epsilon(1e-7));
    CHECK(across.dot(slip) < 0.0);
    CHECK((momentum(net, s) - p).norm() <= 1e-13);
    // Nodes have no spin, so that what friction does about the middle of the line between them is lost: its moment.
    const Vector3 arm = 0.2 * event.normal;
    CHECK((angular_momentum(net, s) - l - arm.cross(event.impulse)).norm() <= 1e-13);
  }
}

TEST_CASE("of a row of balls only the last one flies off") {
  // Gaps between them, so that the impacts come one after the other.
  Network net;
  const int count = 6;
  for (int i = 0; i < count; ++i)
    add_ball(net, "ball " + std::to_string(i), {0.25 * i + (i > 0 ? 0.5 : 0.0), 0, 0}, {i == 0 ? 1.0 : 0.0, 0, 0}, 0.4,
             0.1);
  touch_all(net, frictionless, 1.0);
  for (const double h : {0.003, 0.11}) {  // one impact in a step, and several
    CAPTURE(h);
    Simulation s = simulate(net, verlet, h);
    while (s.time() < 2.0) s.step();
    for (NodeIndex k = 0; k + 1 < count; ++k) CHECK(s.velocity(k).norm() <= 1e-12);
    CHECK((s.velocity(count - 1) - Vector3(1, 0, 0)).norm() <= 1e-12);
  }
}

TEST_CASE("balls rest on each other, and what carries them feels their weight") {
  const double m = 0.3, radius = 0.1;
  const int count = 4;
  Simulation s = simulate(pile_of_balls(count, m, radius), verlet, 0.01);
  advance(s, 300);
  check_pile(s, count, m, radius);
}

TEST_CASE("a moved ball pushes another one along, with the force that this takes") {
  const double m = 0.4, a = 3.0;
  Network net;
  const NodeIndex pusher = add_ball(net, "pusher", {0, 0, 0}, at_rest, 1.0, 0.1);
  add_ball(net, "ball", {0.2, 0, 0}, at_rest, m, 0.1);
  touch_all(net, frictionless);
  Motion motion;  // a t^2 / 2 for a while, by a table that is dense enough for its cubics
  for (int i = 0; i <= 100; ++i) {
    motion.times.push_back(0.01 * i);
    motion.displacements.emplace_back(0.5 * a * motion.times.back() * motion.times.back(), 0, 0);
  }
  net.add_move({{pusher}, motion});
  Simulation s = simulate(net, verlet, 0.004);
  advance(s, 200);
  CHECK(s.position(1)[0] - s.position(0)[0] == doctest::Approx(0.2).epsilon(1e-4));
  CHECK(s.velocity(1)[0] == doctest::Approx(a * s.time()).epsilon(1e-2));
  REQUIRE(s.body_touches().size() == 1);
  // Over a step; the cubics of the table have the acceleration to some per cent.
  CHECK(s.body_touches()[0].force.norm() == doctest::Approx(m * a).epsilon(0.1));
}

TEST_CASE("a ball that a moved one strikes flies off with (1 + e) of its speed") {
  const double speed = 2.0, e = 0.5;
  Network net;
  const NodeIndex club = add_ball(net, "club", {0, 0, 0}, at_rest, 1.0, 0.1);
  add_ball(net, "ball", {0.5, 0, 0}, at_rest, 0.4, 0.1);
  touch_all(net, frictionless, e);
  Motion motion;
  motion.interpolation = Motion::Interpolation::linear;
  motion.times = {0.0, 1.0};
  motion.displacements = {Vector3::Zero(), Vector3(speed, 0, 0)};
  net.add_move({{club}, motion});
  Simulation s = simulate(net, verlet, 0.007);
  while (s.time() < 0.2) s.step();
  const double leaves = (1.0 + e) * speed;
  CHECK(s.velocity(1)[0] == doctest::Approx(leaves).epsilon(1e-12));
  CHECK(s.position(1)[0] == doctest::Approx(0.5 + leaves * (s.time() - 0.15)).epsilon(1e-9));
}

TEST_CASE("balls that meet on a floor exchange what they would without it, and the floor carries them") {
  const double m = 1.5, n = 0.5, speed = 2.0, e = 0.5;
  for (const double mu : {0.0, 0.2}) {
    CAPTURE(mu);
    Network net;
    add_ball(net, "a", {-0.5, 0, 0}, {speed, 0, 0}, m, 0.1);
    add_ball(net, "b", {0.3, 0, 0}, at_rest, n, 0.1);
    touch_all(net, frictionless, e);
    Plane floor;
    floor.friction = {Friction::Kind::coulomb, mu};
    net.add_plane(floor);
    net.set_gravity({0, 0, -9.81});
    Simulation s = simulate(net, verlet, 0.001);
    const auto met = [&] { return count_events(s).met > 0; };
    while (!met()) s.step();
    // They meet after 0.6 m: v^2 = v0^2 - 2 mu g 0.6; the time of the impact is within its step.
    const double arrives = std::sqrt(speed * speed - 2.0 * mu * 9.81 * 0.6);
    const double impulse = (1.0 + e) * m * n / (m + n) * arrives;
    CHECK(s.velocity(0)[0] == doctest::Approx(arrives - impulse / m).epsilon(mu > 0.0 ? 5e-3 : 1e-9));
    CHECK(s.velocity(1)[0] == doctest::Approx(impulse / n).epsilon(mu > 0.0 ? 5e-3 : 1e-9));
    advance(s, 20);
    for (const NodeIndex k : {0u, 1u}) CHECK(std::abs(s.position(k)[2]) <= 1e-9);
  }
}

TEST_CASE("balls that others push do not pass an obstacle, and it carries those on top") {
  Network net;
  add_ball(net, "low", {0, 0, 0.0006}, at_rest, 0.1, 0.1);
  add_ball(net, "heavy", {0, 0, 0.35}, {0, 0, -3}, 5.0, 0.1);
  touch_all(net, frictionless);
  Instrument bar;
  bar.first = {-1, 0, -0.001};
  bar.second = {1, 0, -0.001};
  bar.radius = 0.001;
  bar.friction = {};
  net.add_instrument(bar);
  net.set_gravity({0, 0, -9.81});
  for (const double h : {0.002, 0.01}) {
    CAPTURE(h);
    Simulation s = simulate(net, verlet, h);
    while (s.time() < 0.5) {
      s.step();
      REQUIRE(s.position(0)[2] >= -1e-6);
      REQUIRE(s.position(1)[2] - s.position(0)[2] >= 0.2 - 3e-5);
    }
    CHECK(s.surface_force(0)[2] == doctest::Approx(-5.1 * 9.81).epsilon(1e-3));
    CHECK(s.reaction(0)[2] == doctest::Approx(5.1 * 9.81).epsilon(1e-3));
  }
}

// Balls wider than the springs between them: those that a spring joins overlap, the others never meet.
TEST_CASE("balls that springs join do not touch: no bit of their motion changes") {
  for (const LawUse& integrator : {verlet, recurrent(newton, 1e-9), reference(1e-6)}) {
    CAPTURE(integrator.id);
    std::vector<Vector3> without;
    for (const bool contact : {false, true}) {
      Network net;
      net.begin_body("rope");
      const MaterialIndex material = net.add_material(damped(200.0, 0.1));
      for (int i = 0; i < 8; ++i) {
        Node node = point({0.1 * i, 0, 0}, 0.02, {0, 0.1 * i, 0});
        node.fixed = i == 0;
        if (node.fixed) node.velocity.setZero();
        net.add_node(node);
      }
      for (NodeIndex i = 0; i + 1 < 8; ++i) net.add_spring(i, i + 1, material);
      net.end_body();
      net.set_extent(0, 0.0, 0.06);
      if (contact) touch_all(net, {Friction::Kind::coulomb, 0.3});
      Simulation s = simulate(net, integrator, 0.001);
      advance(s, 100);
      CHECK(s.body_touches().empty());
      for (NodeIndex k = 0; k < 8; ++k) {
        if (contact)
          CHECK(s.position(k) == without[k]);
        else
          without.push_back(s.position(k));
      }
    }
  }
}
