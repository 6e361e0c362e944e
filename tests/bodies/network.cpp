// Contact of bodies inside the fixed point of the recurrent network, by every update rule.

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <springnet/events.hpp>

#include "bodies.hpp"
#include "crossings.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {}  // namespace

TEST_CASE("in the network two balls in a line exchange what Newton's law of impact says, by every rule") {
  const double m = 2.0, n = 0.7, gap = 0.9, speed = 1.3, h = 0.01;
  for (const std::string rule : update_rules) {
    for (const double theta : {1.0, 0.5}) {
      for (const double e : {0.0, 0.4, 1.0}) {
        CAPTURE(rule);
        CAPTURE(theta);
        CAPTURE(e);
        Network net;
        add_ball(net, "a", {0, 0, 0}, {speed, 0, 0}, m, 0.1);
        add_ball(net, "b", {gap + 0.35, 0, 0}, at_rest, n, 0.25);
        touch_all(net, frictionless, e);
        Simulation s = simulate(net, recurrent(update_named(rule), 1e-12, {{"theta", theta}}), h);
        advance(s, 200);
        const double impulse = (1.0 + e) * m * n / (m + n) * speed, met = gap / speed, rest = 2.0 - met;
        const double first = speed - impulse / m, second = impulse / n;
        CHECK(s.velocity(0)[0] == doctest::Approx(first).epsilon(1e-12));
        CHECK(s.velocity(1)[0] == doctest::Approx(second).epsilon(1e-12));
        // The rest of the step in which they meet is lost.
        CHECK(std::abs(s.position(0)[0] - gap - rest * first) <= h * speed);
        CHECK(std::abs(s.position(1)[0] - gap - 0.35 - rest * second) <= (1.0 + e) * h * speed);
        REQUIRE(s.events().size() >= 1);
        const Event& event = s.events().front();
        CHECK(event.kind == Event::Kind::met);
        CHECK(std::abs(event.impulse[0]) == doctest::Approx(impulse).epsilon(1e-12));
      }
    }
  }
}

TEST_CASE("in the network balls rest on each other, and what carries them feels their weight, by every rule") {
  const double m = 0.3, radius = 0.1;
  const int count = 4;
  const Network net = pile_of_balls(count, m, radius);
  for (const std::string rule : update_rules) {
    for (const double theta : {1.0, 0.5}) {
      CAPTURE(rule);
      CAPTURE(theta);
      Simulation s = simulate(net, recurrent(update_named(rule), 1e-10, {{"theta", theta}}), 0.01);
      advance(s, 100);
      check_pile(s, count, m, radius);
      CHECK(s.reaction(0)[2] == doctest::Approx((1.0 + count * m) * g).epsilon(1e-5));
    }
  }
}

TEST_CASE("in the network a ball on an inclined sheet sticks below the angle of friction, and slides above it") {
  const double mu = 0.5, time = 0.3;
  for (const std::string rule : update_rules) {
    for (const double angle : {std::atan(mu) - 1e-3, std::atan(mu) + 1e-3, 0.7}) {
      CAPTURE(rule);
      CAPTURE(angle);
      Network net;
      const Vector3 down(std::cos(angle), 0, -std::sin(angle)), up(std::sin(angle), 0, std::cos(angle));
      add_sheet(net, "incline", 21, 4.0, {0, 0, 0}, down, Vector3::UnitY(), 0.02, 1.0, true);
      const NodeIndex ball = add_ball(net, "ball", -1.5 * down + 0.06 * up + Vector3(0, 0.013, 0), at_rest, 0.3, 0.05);
      touch(net, 0, 1, {Friction::Kind::coulomb, mu});
      net.set_gravity({0, 0, -g});
      Simulation s = simulate(net, recurrent(update_named(rule), 1e-11, {{"theta", 0.5}}), 0.002);
      const Vector3 start = s.position(ball);
      advance(s, 150);
      const double a = std::max(0.0, g * (std::sin(angle) - mu * std::cos(angle)));
      CHECK((s.position(ball) - start - 0.5 * a * time * time * down).norm() <= 1e-5);
      CHECK((s.velocity(ball) - a * time * down).norm() <= 1e-5);
      Vector3 force = Vector3::Zero();
      for (const BodyTouch& each : s.body_touches()) force += (each.nodes[0] == ball ? 1.0 : -1.0) * each.force;
      CHECK((force - 0.3 * (Vector3(0, 0, g) + a * down)).norm() <= 1e-4);
    }
  }
}

TEST_CASE("in the network blocks that meet keep momentum, do not enter each other, and every rule agrees") {
  for (const double mu : {0.0, 0.4}) {
    CAPTURE(mu);
    Network net;
    add_block(net, "left", 3, 0.1, {-0.35, 0.03, 0.02}, {1.5, 0, 0.1}, 0.02, 0.01, 300.0, 0.05);
    add_block(net, "right", 4, 0.08, {0.0, 0.0, 0.0}, {-0.5, 0.2, 0}, 0.02, 0.006, 300.0, 0.05);
    touch(net, 0, 1, {Friction::Kind::coulomb, mu});
    std::vector<std::vector<Vector3>> ends;
    for (const std::string rule : update_rules) {
      CAPTURE(rule);
      Simulation s = simulate(net, recurrent(update_named(rule), 1e-9), 0.002);
      const Vector3 p = momentum(net, s);
      bool met = false;
      for (int i = 0; i < 120; ++i) {
        s.step();
        met = met || !s.body_touches().empty();
        if (i % 10 == 0) REQUIRE(count_crossings(net, s) == 0);
      }
      CHECK(met);
      CHECK(count_events(s).met > 0);
      CHECK((momentum(net, s) - p).norm() <= 1e-6);
      std::vector<Vector3>& end = ends.emplace_back();
      for (NodeIndex k = 0; k < net.nodes().size(); ++k) end.push_back(s.position(k));
    }
    // Of faces on faces the share of friction that each pair has is not unique.
    const double agreement = mu > 0.0 ? 5e-4 : 1e-6;
    for (const std::vector<Vector3>& other : ends) {
      double greatest = 0.0;
      for (std::size_t k = 0; k < other.size(); ++k) greatest = std::max(greatest, (other[k] - ends[0][k]).norm());
      CHECK(greatest <= agreement);
    }
  }
}

TEST_CASE("in the network what never touches moves in the same bits as without contact, by every rule") {
  Network net;
  add_block(net, "left", 3, 0.1, {-1.35, 0.03, 0.02}, {0.3, 0, 0.1}, 0.02, 0.01, 300.0, 0.05);
  add_block(net, "right", 3, 0.08, {0.0, 0.0, 0.3}, {-0.5, 0.2, 0}, 0.02, 0.006, 300.0, 0.05);
  net.set_gravity({0, 0, -9.81});
  Network with = net;
  touch_all(with, {Friction::Kind::coulomb, 0.2}, 0.5);
  for (const std::string rule : update_rules) {
    CAPTURE(rule);
    const LawUse of_rule = recurrent(update_named(rule), 1e-9, {{"theta", 0.6}});
    Simulation a = simulate(net, of_rule, 0.002), b = simulate(with, of_rule, 0.002);
    for (int i = 0; i < 100; ++i) {
      a.step();
      b.step();
      REQUIRE(a.positions() == b.positions());
      REQUIRE(a.velocities() == b.velocities());
    }
  }
}

TEST_CASE("steps of the network tend to the motion that velocity Verlet finds, with their first order") {
  Network net;
  add_block(net, "left", 3, 0.1, {-0.25, 0.03, 0.02}, {1.5, 0, 0.1}, 0.02, 0.01, 300.0, 0.05);
  add_block(net, "right", 4, 0.08, {0.0, 0.0, 0.0}, {-0.5, 0.2, 0}, 0.02, 0.006, 300.0, 0.05);
  touch(net, 0, 1, frictionless);
  const double until = 0.1;
  const auto ends_at = [&](const LawUse& integrator, double h) {
    Simulation s = simulate(net, integrator, h);
    while (s.time() < until - 1e-9) s.step();
    REQUIRE(count_events(s).met > 0);
    std::vector<Vector3> end;
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) end.push_back(s.position(k));
    return end;
  };
  const std::vector<Vector3> reference = ends_at(verlet, 2e-5);
  std::vector<double> errors;
  for (const double h : {2e-3, 1e-3, 5e-4}) {
    const std::vector<Vector3> end = ends_at(recurrent(newton, 1e-7), h);
    double greatest = 0.0;
    for (std::size_t k = 0; k < end.size(); ++k) greatest = std::max(greatest, (end[k] - reference[k]).norm());
    errors.push_back(greatest);
  }
  CAPTURE(errors[0]);
  CAPTURE(errors[1]);
  CAPTURE(errors[2]);
  CHECK(errors[2] <= 5e-3);  // they moved 0.2 m
  for (const std::size_t i : {0u, 1u}) CHECK(errors[i + 1] <= 0.7 * errors[i]);
}

TEST_CASE("in the network a node that is fired at a sheet at a hundred thicknesses a step does not pass") {
  const double thickness = 0.002, h = 0.01, speed = 100.0 * thickness / h;
  for (const std::string rule : update_rules) {
    for (const bool fixed : {true, false}) {
      for (const Vector3& direction : {Vector3(0, 0, -1), Vector3(0.3, -0.5, -1.0), Vector3(1.0, 0.2, -0.1)}) {
        CAPTURE(rule);
        CAPTURE(fixed);
        CAPTURE(direction.transpose());
        Network net;
        const std::size_t sheet = add_sheet(net, "sheet", 7, 0.6, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(),
                                            thickness, 0.01, fixed, 2000.0);
        const Vector3 v = speed * direction.normalized();
        const NodeIndex ball = add_ball(net, "ball", -3.37 * h * v + Vector3(0.02, 0.03, 0), v, 0.005, 0.001);
        touch(net, sheet, net.bodies().size() - 1, frictionless);
        Simulation s = simulate(net, recurrent(update_named(rule), 1e-6), h / (fixed ? 1.0 : 20.0));
        const Vector3 p = momentum(net, s);
        advance(s, fixed ? 8 : 160);
        REQUIRE(!s.events().empty());
        if (fixed) {
          CHECK(s.position(ball)[2] >= 0.002 - 3e-7);  // the tolerance of gaps
          CHECK((s.velocity(ball) - Vector3(v[0], v[1], 0)).norm() <= 1e-6);
        } else {
          CHECK((momentum(net, s) - p).norm() <= 1e-7);
          CHECK(count_crossings(net, s) == 0);
        }
      }
    }
  }
}

TEST_CASE("in the network bodies and obstacles carry each other, in long steps, and none enters another") {
  const int count = 3;
  const double mass = 0.02;
  const Network net = dropped_blocks(count, mass);
  Simulation s = simulate(net, recurrent(newton, 1e-5), 0.005);
  while (s.time() < 0.6) {
    s.step();
    if (s.steps() % 10 == 0) REQUIRE(count_crossings(net, s) == 0);
  }
  double fastest = 0.0;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) fastest = std::max(fastest, s.velocity(k).norm());
  CHECK(fastest <= 0.05);  // they fell at 1 m/s; backward Euler damps what rocks
  CHECK(-s.surface_force(0)[2] == doctest::Approx(count * 27 * mass * g).epsilon(0.05));
}

TEST_CASE("in the network a moved ball pushes another one on a floor, and strikes a third with (1 + e) of its speed") {
  const double speed = 2.0, e = 0.5;
  for (const std::string rule : update_rules) {
    CAPTURE(rule);
    Network net;
    const NodeIndex club = add_ball(net, "club", {0, 0, 0}, at_rest, 1.0, 0.1);
    add_ball(net, "ball", {0.5, 0, 0}, at_rest, 0.4, 0.1);
    touch_all(net, frictionless, e);
    Plane floor;
    floor.friction = frictionless;
    net.add_plane(floor);
    net.set_gravity({0, 0, -g});
    Motion motion;
    motion.interpolation = Motion::Interpolation::linear;
    motion.times = {0.0, 1.0};
    motion.displacements = {Vector3::Zero(), Vector3(speed, 0, 0)};
    net.add_move({{club}, motion});
    Simulation s = simulate(net, recurrent(update_named(rule), 1e-9), 0.007);
    while (s.time() < 0.2) s.step();
    CHECK(s.velocity(1)[0] == doctest::Approx((1.0 + e) * speed).epsilon(1e-9));
    CHECK(std::abs(s.position(1)[2]) <= 1e-9);
  }
}

TEST_CASE("in the network contact of bodies has the same bits for every number of threads, and after a saved state") {
  Network net;
  add_block(net, "left", 4, 0.1, {-0.35, 0.03, 0.02}, {1.5, 0, 0.1}, 0.02, 0.01, 300.0, 0.05);
  add_block(net, "right", 4, 0.08, {0.0, 0.0, 0.0}, {-0.5, 0.2, 0}, 0.02, 0.006, 300.0, 0.05);
  touch(net, 0, 1, {Friction::Kind::coulomb, 0.3});
  for (const std::string rule : {"synchronous", "coloured", "newton"}) {
    CAPTURE(rule);
    check_bits(net, recurrent(update_named(rule), 1e-7), 0.001, 60, 20);
  }
}

TEST_CASE("in the network friction of an impact is in Coulomb's cone, and floors bear what bodies press on them") {
  const double mu = 0.3;
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    Network net;
    add_ball(net, "wall", {0, 0, 0}, at_rest, 1.0, 0.1, true);
    add_ball(net, "ball", {0, 0, 0.2001}, {2.0, 0, -1.0}, 0.5, 0.1);
    touch_all(net, {Friction::Kind::coulomb, mu});
    Simulation s = simulate(net, recurrent(newton, 1e-10, {{"theta", theta}}), 0.001);
    while (s.events().empty()) s.step();
    const Event& event = s.events().front();
    const double along = std::abs(event.normal.dot(event.impulse));
    const double across = (event.impulse - event.normal * event.normal.dot(event.impulse)).norm();
    CHECK(across == doctest::Approx(mu * along).epsilon(1e-4));
  }
  Network net;
  add_ball(net, "low", {0, 0, 0}, at_rest, 0.5, 0.1);
  add_ball(net, "high", {0, 0, 0.2}, at_rest, 0.3, 0.1);
  touch_all(net, frictionless);
  Plane floor;
  floor.friction = frictionless;
  net.add_plane(floor);
  net.set_gravity({0, 0, -g});
  Simulation s = simulate(net, recurrent(newton, 1e-10), 0.01);
  advance(s, 50);
  CHECK(s.surface_force(0)[2] == doctest::Approx(-0.8 * g).epsilon(1e-6));
  // Impulses are what the forces at the ends of steps leave out: only of the first step, before bodies touched.
  const Vector3 before = s.surface_impulse(0);
  advance(s, 50);
  CHECK((s.surface_impulse(0) - before).norm() <= 1e-6 * 0.8 * g);
}

TEST_CASE("in the network elastic bodies that bounce off each other go on as in small steps") {
  Network net;
  add_block(net, "left", 3, 0.1, {-0.24, 0.03, 0.02}, {1.0, 0, 0}, 0.02, 0.01, 300.0, 0.05);
  add_block(net, "right", 3, 0.1, {0.0, 0.0, 0.0}, {-0.5, 0, 0}, 0.02, 0.01, 300.0, 0.05);
  touch(net, 0, 1, frictionless, 0.5);
  std::vector<std::vector<Vector3>> ends;
  for (const double rule : {wavefront, newton}) {
    Simulation s = simulate(net, recurrent(rule, 1e-7), 0.001);
    while (s.time() < 0.1 - 1e-9) s.step();
    std::vector<Vector3>& end = ends.emplace_back();
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) end.push_back(s.position(k));
  }
  double greatest = 0.0;
  for (std::size_t k = 0; k < ends[0].size(); ++k) greatest = std::max(greatest, (ends[0][k] - ends[1][k]).norm());
  // Which pairs of faces on faces press is not unique, and those that do rebound: they moved 0.1 m.
  CHECK(greatest <= 2e-3);
}
