// Contact of bodies whose events are located: the reference, against closed forms.

#include <doctest/doctest.h>

#include <cmath>

#include <springnet/error.hpp>
#include <springnet/events.hpp>

#include "bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {}  // namespace

TEST_CASE("the reference: two balls in a line exchange what Newton's law of impact says") {
  const double m = 2.0, n = 0.7, gap = 0.9, speed = 1.3;
  for (const double e : {0.0, 0.4, 1.0}) {
    CAPTURE(e);
    Network net;
    add_ball(net, "a", {0, 0, 0}, {speed, 0, 0}, m, 0.1);
    add_ball(net, "b", {gap + 0.35, 0, 0}, at_rest, n, 0.25);
    touch_all(net, frictionless, e);
    Simulation s = simulate(net, reference(), 0.01);
    advance(s, 200);
    const double impulse = (1.0 + e) * m * n / (m + n) * speed, met = gap / speed, rest = 2.0 - met;
    const double first = speed - impulse / m, second = impulse / n;
    CHECK(s.velocity(0)[0] == doctest::Approx(first).epsilon(1e-9));
    CHECK(s.velocity(1)[0] == doctest::Approx(second).epsilon(1e-9));
    CHECK(s.position(0)[0] == doctest::Approx(gap + rest * first).epsilon(1e-9));
    CHECK(s.position(1)[0] == doctest::Approx(gap + 0.35 + rest * second).epsilon(1e-9));
    REQUIRE(s.events().size() >= 1);
    const Event& event = s.events().front();
    CHECK(event.kind == Event::Kind::met);
    CHECK(event.time == doctest::Approx(met).epsilon(1e-9));
    CHECK(event.pair_first == 1);
    CHECK(event.pair_count == 2);
    CHECK(std::abs(event.impulse[0]) == doctest::Approx(impulse).epsilon(1e-9));
    CHECK(s.body_touches().size() == (e == 0.0 ? 1u : 0u));
  }
}

TEST_CASE("the reference: two balls that meet at an angle keep momentum, angular momentum and their slip") {
  const double radius = 0.2, offset = 0.15;
  Network net;
  add_ball(net, "a", {-1, offset, 0.05}, {2, 0, 0}, 1.5, radius);
  add_ball(net, "b", {0.4, 0, 0}, {-1, 0.2, 0}, 0.8, radius);
  touch_all(net, frictionless, 0.6);
  Simulation s = simulate(net, reference(), 0.013);
  const Vector3 p = momentum(net, s), l = angular_momentum(net, s);
  const Vector3 before = s.velocity(0) - s.velocity(1);
  advance(s, 100);
  CHECK((momentum(net, s) - p).norm() <= 1e-14 * 5.0);
  CHECK((angular_momentum(net, s) - l).norm() <= 1e-10);
  REQUIRE(!s.events().empty());
  const Vector3 n = s.events().front().normal, after = s.velocity(0) - s.velocity(1);
  CHECK(n.dot(after) == doctest::Approx(-0.6 * n.dot(before)).epsilon(1e-9));
  CHECK((after - n * n.dot(after) - before + n * n.dot(before)).norm() <= 1e-9);
  const Vector3 d = Vector3(-1, offset, 0.05) - Vector3(0.4, 0, 0);
  const double a = before.squaredNorm(), b = d.dot(before), c = d.squaredNorm() - 4.0 * radius * radius;
  const double time = (-b - std::sqrt(b * b - a * c)) / a;
  CHECK(s.events().front().time == doctest::Approx(time).epsilon(1e-9));
  CHECK((n - (d + time * before) / (2.0 * radius)).norm() <= 1e-9);
}

TEST_CASE("the reference: friction of balls that meet lies in Coulomb's cone, and ends the slip if it can") {
  const double m = 1.0, n = 3.0;
  for (const double mu : {0.1, 5.0}) {
    CAPTURE(mu);
    Network net;
    add_ball(net, "a", {-0.5, 0.0, 0.0}, {2, 0.3, 0}, m, 0.1);
    add_ball(net, "b", {0.3, 0.1, 0}, {0, 0, 0}, n, 0.1);
    touch_all(net, {Friction::Kind::coulomb, mu});
    Simulation s = simulate(net, reference(), 0.01);
    const Vector3 p = momentum(net, s), before = s.velocity(0) - s.velocity(1);
    while (s.events().empty()) s.step();
    const Event event = s.events().front();
    const Vector3 along = event.normal * event.normal.dot(event.impulse), across = event.impulse - along;
    const Vector3 slip = before - event.normal * event.normal.dot(before);
    const double reduced = m * n / (m + n), needed = reduced * slip.norm();
    CHECK(along.norm() == doctest::Approx(-reduced * event.normal.dot(before)).epsilon(1e-9));
    CHECK(across.norm() == doctest::Approx(std::min(mu * along.norm(), needed)).epsilon(1e-9));
    CHECK(across.dot(slip) < 0.0);
    CHECK((momentum(net, s) - p).norm() <= 1e-13);
  }
}

TEST_CASE("the reference: a ball that slides off a fixed one leaves it where cos is two thirds") {
  const double radius = 0.5, start = 0.1;
  Network net;
  add_ball(net, "low", {0, 0, 0}, at_rest, 1.0, 0.3, true);
  add_ball(net, "high", radius * Vector3(std::sin(start), 0, std::cos(start)), at_rest, 0.7, 0.2);
  touch_all(net, frictionless);
  net.set_gravity({0, 0, -g});
  Simulation s = simulate(net, reference(), 0.01);
  while (count_events(s).parted == 0 && s.time() < 3.0) s.step();
  REQUIRE(count_events(s).parted == 1);
  const Event& event = s.events().back();
  // Energy: v^2 = 2 g r (cos a - cos b); it leaves where v^2 / r = g cos b.
  const double leaves = 2.0 / 3.0 * std::cos(start);
  CHECK(event.normal[2] * (event.pair[0] == 1 ? 1.0 : -1.0) == doctest::Approx(leaves).epsilon(1e-8));
  const double speed = std::sqrt(g * radius * leaves);
  CHECK(s.velocity(1)[0] == doctest::Approx(speed * leaves).epsilon(1e-8));
}

TEST_CASE("the reference: a ball on an inclined sheet sticks below the angle of friction, and slides above it") {
  const double mu = 0.5, time = 0.6;
  for (const double angle : {0.2, std::atan(mu) - 1e-3, std::atan(mu) + 1e-3, 0.7}) {
    CAPTURE(angle);
    Network net;
    const Vector3 down(std::cos(angle), 0, -std::sin(angle)), up(std::sin(angle), 0, std::cos(angle));
    add_sheet(net, "incline", 21, 4.0, {0, 0, 0}, down, Vector3::UnitY(), 0.02, 1.0, true);
    const NodeIndex ball = add_ball(net, "ball", -1.5 * down + 0.06 * up + Vector3(0, 0.013, 0), at_rest, 0.3, 0.05);
    touch(net, 0, 1, {Friction::Kind::coulomb, mu});
    net.set_gravity({0, 0, -g});
    Simulation s = simulate(net, reference(), 0.01);
    const Vector3 start = s.position(ball);
    advance(s, 60);
    const double a = std::max(0.0, g * (std::sin(angle) - mu * std::cos(angle)));
    // Each of some 20 faces that it passes begins the integration anew, with errors of 1e-10 of 3 m/s in many steps.
    CHECK((s.position(ball) - start - 0.5 * a * time * time * down).norm() <= 1e-7);
    CHECK((s.velocity(ball) - a * time * down).norm() <= 1e-7);
    REQUIRE(!s.body_touches().empty());
    Vector3 force = Vector3::Zero();
    for (const BodyTouch& each : s.body_touches()) force += (each.nodes[0] == ball ? 1.0 : -1.0) * each.force;
    CHECK((force - 0.3 * (Vector3(0, 0, g) + a * down)).norm() <= 1e-7);
  }
}

TEST_CASE("the reference: balls rest on each other, and what carries them feels their weight") {
  const double m = 0.3, radius = 0.1;
  const int count = 4;
  Simulation s = simulate(pile_of_balls(count, m, radius), reference(), 0.1);
  advance(s, 30);
  check_pile(s, count, m, radius);
  CHECK(s.reaction(0)[2] == doctest::Approx((count * m + 1.0) * g).epsilon(1e-9));
}

TEST_CASE("the reference: balls that meet on a floor exchange what they would without it, and the floor carries them") {
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
    net.set_gravity({0, 0, -g});
    Simulation s = simulate(net, reference(), 0.001);
    const auto met = [&] { return count_events(s).met > 0; };
    while (!met()) s.step();
    // They meet after 0.6 m: v^2 = v0^2 - 2 mu g 0.6.
    const double arrives = std::sqrt(speed * speed - 2.0 * mu * g * 0.6);
    const double impulse = (1.0 + e) * m * n / (m + n) * arrives, slowed = mu * g * (s.time() - s.events().back().time);
    CHECK(s.velocity(0)[0] == doctest::Approx(arrives - impulse / m - slowed).epsilon(1e-8));
    CHECK(s.velocity(1)[0] == doctest::Approx(impulse / n - slowed).epsilon(1e-8));
    advance(s, 20);
    for (const NodeIndex k : {0u, 1u}) CHECK(std::abs(s.position(k)[2]) <= 1e-9);
  }
}

TEST_CASE("the reference: a ball shot across an inclined sheet turns downhill, and stops when its equation says") {
  // With a = g sin(angle), b = mu g cos(angle), the speed v and its angle p to the line of fall:
  // v' = a cos p - b, (v cos p)' = a - b cos p, so that b v + a v cos p falls at the rate b^2 - a^2.
  const double angle = 0.3, speed = 1.0;
  for (const double mu : {0.35, 0.5, 0.9}) {
    CAPTURE(mu);
    Network net;
    const Vector3 down(std::cos(angle), 0, -std::sin(angle)), up(std::sin(angle), 0, std::cos(angle));
    add_sheet(net, "incline", 2, 8.0, {0, 0, 0}, down, Vector3::UnitY(), 0.02, 1.0, true);
    const NodeIndex ball =
        add_ball(net, "ball", -2.0 * down + 0.06 * up + Vector3(0, 0.5, 0), {0, speed, 0}, 0.3, 0.05);
    touch(net, 0, 1, {Friction::Kind::coulomb, mu});
    net.set_gravity({0, 0, -g});
    Simulation s = simulate(net, reference(), 0.01);
    const double a = g * std::sin(angle), b = mu * g * std::cos(angle), stops = speed * b / (b * b - a * a);
    while (s.time() < stops + 0.1) s.step();
    CHECK(s.velocity(ball).norm() <= 1e-12);
    REQUIRE(count_events(s).stuck == 1);
    // Slower than 1e-6 of the scale of speeds, friction keeps its direction.
    CHECK(std::abs(s.events().back().time - stops) <= 5e-8);
  }
}

TEST_CASE("the reference: a ball pushed against another one on a floor with friction, and both against a third") {
  // a is pulled with F; b and c lie in its way on the floor: all three slide with F / M - mu g.
  const double m = 0.3, f = 4.0, mu = 0.2;
  Network net;
  for (int i = 0; i < 3; ++i) add_ball(net, "ball " + std::to_string(i), {0.2 * i, 0, 0}, at_rest, m * (i + 1), 0.1);
  touch_all(net, frictionless);
  Plane floor;
  floor.friction = {Friction::Kind::coulomb, mu};
  net.add_plane(floor);
  net.set_gravity({0, 0, -g});
  net.add_load({{0}, {f, 0, 0}});
  Simulation s = simulate(net, reference(), 0.01);
  advance(s, 50);
  const double a = f / (6.0 * m) - mu * g;
  for (const NodeIndex k : {0u, 1u, 2u}) {
    CHECK(s.position(k)[0] == doctest::Approx(0.2 * k + 0.5 * a * 0.25).epsilon(1e-8));
    CHECK(s.velocity(k)[0] == doctest::Approx(0.5 * a).epsilon(1e-8));
    CHECK(s.reaction(k)[0] == doctest::Approx(-mu * m * (k + 1) * g).epsilon(1e-7));
  }
  REQUIRE(s.body_touches().size() == 2);
  for (const BodyTouch& each : s.body_touches()) {
    const NodeIndex last = std::max(each.nodes[0], each.nodes[1]);
    const double carried = last == 1 ? 5.0 * m : 3.0 * m;
    CHECK(each.force.norm() == doctest::Approx(carried * (a + mu * g)).epsilon(1e-7));
  }
}

TEST_CASE("the reference: a ball that slides with friction over a fixed one moves as its equation says") {
  // v dv/ds = g sin b - mu (g cos b - v^2 / r), in u = v^2: du/db = 2 r g (sin b - mu cos b) + 2 mu u.
  const double radius = 0.5, start = 0.6, mu = 0.2;
  Network net;
  add_ball(net, "low", {0, 0, 0}, at_rest, 1.0, 0.3, true);
  add_ball(net, "high", radius * Vector3(std::sin(start), 0, std::cos(start)), at_rest, 0.7, 0.2);
  touch_all(net, {Friction::Kind::coulomb, mu});
  net.set_gravity({0, 0, -g});
  Simulation s = simulate(net, reference(), 0.01);
  while (count_events(s).parted == 0 && s.time() < 3.0) s.step();
  REQUIRE(count_events(s).parted == 1);
  // The solution with u(start) = 0, and where u = r g cos b.
  const double k = 2.0 * mu, c = 2.0 * radius * g;
  const auto particular = [&](double b) {
    return -c / (1.0 + k * k) * ((mu + k) * std::sin(b) + (1.0 - k * mu) * std::cos(b));
  };
  const auto u = [&](double b) { return particular(b) - particular(start) * std::exp(k * (b - start)); };
  double low = start, high = 1.5;
  for (int i = 0; i < 100; ++i) {
    const double b = 0.5 * (low + high);
    (u(b) < radius * g * std::cos(b) ? low : high) = b;
  }
  CHECK(std::abs(s.events().back().normal[2]) == doctest::Approx(std::cos(low)).epsilon(1e-8));
}

TEST_CASE("the reference: nothing passes through a sheet at a hundred thicknesses a step") {
  for (const double speed : {100.0, 1000.0}) {
    Network net;
    add_sheet(net, "sheet", 6, 1.0, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(), 0.001, 0.01, false, 1000.0);
    const NodeIndex shot = add_ball(net, "shot", {0.11, 0.07, 0.5}, {0, 0, -speed}, 0.001, 0.0005);
    touch(net, 0, 1, frictionless, 0.5);
    Simulation s = simulate(net, reference(1e-8), 0.1 / speed);
    const Vector3 p = momentum(net, s);
    while (s.time() < 2.0 / speed) s.step();
    REQUIRE(count_events(s).met >= 1);
    CHECK(s.events().front().time == doctest::Approx((0.5 - 0.001) / speed).epsilon(1e-6));
    CHECK((momentum(net, s) - p).norm() <= 1e-9 * p.norm());
    CHECK(s.velocity(shot)[2] > -0.3 * speed);
  }
}
