// Contact of bodies whose events are located: what slides from face to face, over edges and corners.

#include <doctest/doctest.h>

#include <cmath>

#include <springnet/events.hpp>

#include "bodies.hpp"
#include "crossings.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double reach = 0.1;  // m, of a ball from the surface that it slides on

constexpr double of_surface = 0.02;  // m, its thickness

// A ball at this speed on a fixed body.
NodeIndex add_slider(Network& net, const Vector3& position, const Vector3& velocity, const Friction& friction) {
  const NodeIndex ball = add_ball(net, "ball", position, velocity, 0.3, reach - 0.5 * of_surface);
  touch(net, 0, 1, friction);
  return ball;
}

// Two faces of 2 m by 2 m on each side of the y axis, which fall off on both sides at this angle; below zero they rise.
void add_roof(Network& net, double angle) {
  net.begin_body("roof");
  for (const double x : {-2.0, 0.0, 2.0})
    for (const double y : {-1.0, 1.0}) {
      Node node = point({x * std::cos(angle), y, -std::abs(x) * std::sin(angle)}, 1.0);
      node.fixed = true;
      net.add_node(node);
    }
  for (const NodeIndex k : {0u, 2u}) {
    net.add_face({k, k + 2, k + 3});
    net.add_face({k, k + 3, k + 1});
  }
  net.end_body();
  net.set_extent(0, of_surface, 0.0);
}

double energy_of(const Simulation& s) { return s.kinetic_energy() + s.potential_energy(); }

// N s, of all impacts.
double struck(const Simulation& s) {
  double sum = 0.0;
  for (const Event& event : s.events()) sum += event.impulse.norm();
  return sum;
}

// That nothing gains energy, beyond 1e-8 J by the integrator's tolerance, or crosses anything.
void check_decay(const Network& net, Simulation& s, int steps) {
  double energy = energy_of(s);
  for (int i = 0; i < steps; ++i) {
    s.step();
    const double now = energy_of(s);
    CHECK(now <= energy + 1e-8);
    energy = now;
    REQUIRE(count_crossings(net, s) == 0);
  }
}

}  // namespace

TEST_CASE("the reference: a ball slides over faces, edges and corners of a flat sheet as over a plane") {
  const Vector3 n = Vector3(0.3, -0.2, 1.0).normalized(), u = Vector3(1.0, 0.4, -0.22).normalized(), v = n.cross(u);
  // The sheet's squares of 0.25 m are divided along (1, 1): across all, over corners, along edges, along diagonals.
  struct Way {
    Vector3 from, to;
  };
  const Vector3 middle = Vector3::Zero();
  for (const Way& way : {Way{{-0.83, -0.71, 0}, {1.0, 0.77, 0}}, Way{{-0.75, -0.5, 0}, {0.5, 0.25, 0}},
                         Way{{-0.9, 0.25, 0}, {1.0, 0, 0}}, Way{{-0.8, -0.8, 0}, {1.0, 1.0, 0}}})
    for (const double mu : {0.0, 0.15}) {
      CAPTURE(way.to.transpose());
      CAPTURE(mu);
      Network net;
      add_sheet(net, "sheet", 9, 2.0, middle, u, v, of_surface, 1.0, true);
      const auto at = [&](const Vector3& p) -> Vector3 { return p[0] * u + p[1] * v; };
      const Vector3 goes = at(way.to).normalized(), start = at(way.from) + reach * n;
      const double speed = 1.4, duration = 0.8;
      const NodeIndex ball =
          add_slider(net, start, speed * goes, mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless);
      net.set_gravity(-g * n);
      Simulation s = simulate(net, reference(), 0.01);
      advance(s, static_cast<int>(std::lround(duration / 0.01)));
      const double slowed = mu * g, ends = std::min(duration, mu > 0.0 ? speed / slowed : duration);
      const Vector3 expected = start + (speed * ends - 0.5 * slowed * ends * ends) * goes;
      // What stops is located within the tolerance.
      CHECK((s.position(ball) - expected).norm() <= (mu > 0.0 ? 5e-8 : 1e-9));
      CHECK((s.velocity(ball) - (speed - slowed * ends) * goes).norm() <= 1e-7);
      CHECK(struck(s) <= 1e-9);
      CHECK(s.body_touches().size() == 1);
      // Each face that it comes to is one event, and its start; what friction stops is some more.
      CHECK(s.statistics().at("restarts") <= 40.0);
    }
}

TEST_CASE("the reference: a ball slides over a ridge along the circle around it") {
  const double angle = 0.3, top = 0.55;  // m/s, on the ridge: less than sqrt(g reach), where it would fly
  Network net;
  add_roof(net, angle);
  const double slope = g * std::sin(angle), before = 0.2;  // m, of the way up
  const double at_arc = std::sqrt(top * top + 2.0 * g * reach * (1.0 - std::cos(angle)));
  const double speed = std::sqrt(at_arc * at_arc + 2.0 * slope * before);
  const Vector3 up(std::cos(angle), 0.0, std::sin(angle)), n(-std::sin(angle), 0.0, std::cos(angle));
  const NodeIndex ball = add_slider(net, -before * up + reach * n + Vector3(0, 0.13, 0), speed * up, frictionless);
  net.set_gravity({0, 0, -g});
  // s, over the arc: the integral of reach / v over its angle, by Simpson's rule.
  const auto slowness = [&](double turn) {
    return reach / std::sqrt(top * top + 2.0 * g * reach * (1.0 - std::cos(turn)));
  };
  const int parts = 2000;
  double arc = 0.0;
  for (int i = 0; i < parts; ++i) {
    const double h = 2.0 * angle / parts, a = -angle + i * h;
    arc += h / 6.0 * (slowness(a) + 4.0 * slowness(a + 0.5 * h) + slowness(a + h));
  }
  const double climbs = (speed - at_arc) / slope, duration = 0.6, falls = duration - climbs - arc;
  REQUIRE(falls > 0.05);
  Simulation s = simulate(net, reference(), 0.01);
  const double energy = energy_of(s);
  for (int i = 0; i < 60; ++i) {
    s.step();
    CHECK(energy_of(s) == doctest::Approx(energy).epsilon(1e-8));
    CHECK(s.body_touches().size() == 1);
  }
  const Vector3 down(std::cos(angle), 0.0, -std::sin(angle)), m(std::sin(angle), 0.0, std::cos(angle));
  const Vector3 expected = (at_arc * falls + 0.5 * slope * falls * falls) * down + reach * m + Vector3(0, 0.13, 0);
  CHECK((s.position(ball) - expected).norm() <= 1e-7);
  CHECK(struck(s) <= 1e-9);
}

TEST_CASE("the reference: a ball that slides into a valley loses what is across the other side of it") {
  // Also of so flat ones that it touches both sides and what is between them at once, to within the tolerance.
  for (const double angle : {0.2, 1e-3, 1e-5, 1e-8}) {
    CAPTURE(angle);
    Network net;
    add_roof(net, -angle);
    const double speed = 1.2, before = 0.3;
    const Vector3 down(std::cos(angle), 0.0, -std::sin(angle)), n(std::sin(angle), 0.0, std::cos(angle));
    const Vector3 up(std::cos(angle), 0.0, std::sin(angle)), m(-std::sin(angle), 0.0, std::cos(angle));
    const double corner = reach * std::tan(angle);  // m, before the edge
    const NodeIndex ball =
        add_slider(net, -(before + corner) * down + reach * n + Vector3(0, 0.13, 0), speed * down, frictionless);
    net.set_gravity({0, 0, -g});
    Simulation s = simulate(net, reference(), 0.01);
    advance(s, 40);
    const double slope = g * std::sin(angle);
    const double arrives = std::sqrt(speed * speed + 2.0 * slope * before);
    const double falls = 2.0 * before / (speed + arrives), leaves = arrives * std::cos(2.0 * angle), rest = 0.4 - falls;
    const Vector3 expected =
        (leaves * rest - 0.5 * slope * rest * rest + corner) * up + reach * m + Vector3(0, 0.13, 0);
    CHECK((s.position(ball) - expected).norm() <= 1e-7);
    CHECK((s.velocity(ball) - (leaves - slope * rest) * up).norm() <= 1e-6);
  }
}

TEST_CASE("the reference: a ball that friction holds in a flat valley stays, however flat it is") {
  for (const double angle : {0.2, 1e-4, 1e-6, 1e-9}) {
    CAPTURE(angle);
    Network net;
    add_roof(net, -angle);
    const NodeIndex ball = add_slider(net, {0, 0.13, reach / std::cos(angle)}, at_rest, {Friction::Kind::coulomb, 0.4});
    net.set_gravity({0.1 * g, 0.2 * g, -g});
    Simulation s = simulate(net, reference(), 0.01);
    advance(s, 30);
    CHECK((s.position(ball) - Vector3(0, 0.13, reach / std::cos(angle))).norm() <= 1e-8);
    Vector3 carried = Vector3::Zero();
    for (const BodyTouch& each : s.body_touches()) carried += (each.nodes[0] == ball ? 1.0 : -1.0) * each.force;
    CHECK((carried - 0.3 * g * Vector3(-0.1, -0.2, 1.0)).norm() <= 1e-6);
    CHECK(s.statistics().at("restarts") <= 10.0);
  }
}

TEST_CASE(
    "the reference: a ball that the program moves off its face falls, and one moved to another face rests there") {
  Network net;
  add_sheet(net, "sheet", 3, 2.0, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(), of_surface, 1.0, true);
  const NodeIndex ball = add_slider(net, {0.3, 0.123, reach}, at_rest, {Friction::Kind::coulomb, 0.3});
  net.set_gravity({0, 0, -g});
  Simulation s = simulate(net, reference(), 0.01);
  advance(s, 3);
  REQUIRE(s.body_touches().size() == 1);
  s.set_position(ball, {-0.45, -0.2, reach});
  advance(s, 3);
  CHECK((s.position(ball) - Vector3(-0.45, -0.2, reach)).norm() <= 1e-9);
  REQUIRE(s.body_touches().size() == 1);
  CHECK((s.body_touches()[0].position.head<2>() - Vector3(-0.45, -0.2, 0).head<2>()).norm() <= 1e-9);
  s.set_position(ball, {1.6, 0.1, reach});
  advance(s, 3);
  CHECK(s.position(ball)[2] == doctest::Approx(reach - 0.5 * g * 0.03 * 0.03).epsilon(1e-8));
  CHECK(s.body_touches().empty());
}

// Each corner on the corner below it: they meet along edges and diagonals, and slide off these onto faces.
TEST_CASE("the reference: soft boxes exactly above each other bounce, slide and stick") {
  const Network net = boxes_above_each_other(0.01, 0.13, 0.2);
  Simulation s = simulate(net, reference(1e-8), 0.005);
  check_decay(net, s, 44);
  CHECK(count_events(s).met >= 10);
}

TEST_CASE("the reference: soft boxes nearly above each other, whose corners run to and fro over edges") {
  // Corners are on faces by shares of an edge, beside edges that cross at nearly the same place: pairs that are nearly
  // the same constraint, or exactly where corners are on edges. m
  for (const auto& [friction, offset] :
       {std::pair{0.0, 5e-7}, std::pair{0.0, 1e-6}, std::pair{0.0, 7e-6}, std::pair{0.0, 2e-5}, std::pair{0.0, 3e-5},
        std::pair{0.2, 3e-6}, std::pair{0.2, 1e-5}, std::pair{0.2, 5e-5}}) {
    CAPTURE(friction);
    CAPTURE(offset);
    const Network net = boxes_above_each_other(0.01, 0.13, friction, offset);
    Simulation s = simulate(net, reference(1e-6), 0.005);
    check_decay(net, s, 160);
    CHECK(count_events(s).met >= 10);
    CHECK(count_events(s).met <= 500);  // 66 to 158 are found
  }
}

TEST_CASE("the reference: a soft block that buckles slides over borders of the faces below it") {
  Network net;
  for (std::size_t i = 0; i < 2; ++i) {
    const double k = static_cast<double>(i);
    const Lattice lattice{{3, 3, 3}, Vector3::Constant(0.1), {0.007 * k, 0.011 * k, 0.21 * k}, Diagonals::space};
    Node node = point(at_rest, 0.02);
    node.fixed = i == 0;
    net.add_lattice("block " + std::to_string(i), lattice, node, net.add_material(damped(1500.0, 5.0)));
    net.set_extent(i, 0.01, 0.0);
  }
  touch_all(net, frictionless);
  net.set_gravity({0, 0, -g});
  Simulation s = simulate(net, reference(1e-9), 0.005);
  check_decay(net, s, 600);
  CHECK(count_events(s).met >= 20);
}
