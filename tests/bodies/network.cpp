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

namespace {

constexpr double g = 9.81;

}  // namespace

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
  Network net;
  add_ball(net, "ground", {0, 0, 0}, at_rest, 1.0, radius, true);
  const int count = 4;
  for (int i = 0; i < count; ++i)
    add_ball(net, "ball " + std::to_string(i), {0, 0, 2.0 * radius * (i + 1)}, at_rest, m, radius);
  touch_all(net, frictionless);
  net.set_gravity({0, 0, -g});
  for (const std::string rule : update_rules) {
    for (const double theta : {1.0, 0.5}) {
      CAPTURE(rule);
      CAPTURE(theta);
      Simulation s = simulate(net, recurrent(update_named(rule), 1e-10, {{"theta", theta}}), 0.01);
      advance(s, 100);
      for (NodeIndex k = 1; k <= count; ++k) {
        CAPTURE(k);
        CHECK(s.position(k)[2] == doctest::Approx(2.0 * radius * k).epsilon(1e-7));  // the tolerance of gaps, 1e-8
        CHECK(s.velocity(k).norm() <= 1e-6);
      }
      const std::vector<BodyTouch> touches = s.body_touches();
      REQUIRE(touches.size() == count);
      for (const BodyTouch& each : touches) {
        const NodeIndex above = std::max(each.nodes[0], each.nodes[1]);
        CAPTURE(above);
        CHECK(each.force.norm() == doctest::Approx((count + 1.0 - above) * m * g).epsilon(1e-5));
      }
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
      const NodeIndex ball =
          add_ball(net, "ball", -1.5 * down + 0.06 * up + Vector3(0, 0.013, 0), at_rest, 0.3, 0.05);
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
    for (const std::vector<Vector3>& other : ends) {
      double greatest = 0.0;
      for (std::size_t k = 0; k < other.size(); ++k) greatest = std::max(greatest, (other[k] - ends[0][k]).norm());
      CHECK(greatest <= 1e-5);
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
