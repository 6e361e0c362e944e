// Nodes that slide along two surfaces at once.

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double g = 9.81, mass = 0.7, tilt = 0.4;                   // m/s^2, kg, rad
constexpr double steep_left = 0.6, steep_right = 0.9;                // rad, of the groove's sides
const double along = g * std::sin(tilt), into = g * std::cos(tilt);  // m/s^2
// N1 sin(left) = N2 sin(right), N1 cos(left) + N2 cos(right) = m g cos(tilt).
const double left = mass * into * std::sin(steep_right) / std::sin(steep_left + steep_right);  // N
const double right = mass * into * std::sin(steep_left) / std::sin(steep_left + steep_right);  // N

Plane plane_of(const char* name, const Vector3& normal, const Friction& friction,
               const Vector3& where = Vector3::Zero()) {
  Plane plane;
  plane.name = name;
  plane.point = where;
  plane.normal = normal;
  plane.friction = friction;
  return plane;
}

// A node in a groove along x that is tilted.
Network groove(const Friction& friction, double speed) {
  Network net;
  net.add_node(point(Vector3::Zero(), mass, {speed, 0, 0}));
  net.set_gravity({along, 0, -into});
  net.add_plane(plane_of("left", {0, std::sin(steep_left), std::cos(steep_left)}, friction));
  net.add_plane(plane_of("right", {0, -std::sin(steep_right), std::cos(steep_right)}, friction));
  return net;
}

// First order: h / 2 times the speed gained; second order is exact under constant forces.
double allowed(const Scheme& scheme, double h, double gained) {
  return scheme.order == 1.0 ? 0.51 * h * gained + 1e-12 : scheme.order == 2.0 ? 1e-9 : 1e-7;
}

}  // namespace

TEST_CASE("a node slides down a groove, with the right reactions of its sides") {
  constexpr double h = 0.005, until = 0.6;
  for (const double mu : {0.0, 0.1}) {
    const Friction friction = mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless;
    const double a = along - mu * (left + right) / mass;
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name << ", friction " << mu);
      Simulation s = simulate(groove(friction, 0.0), scheme.integrator, h);
      s.advance_to(until);
      CHECK((s.position(0) - Vector3(0.5 * a * until * until, 0, 0)).norm() <= allowed(scheme, h, a * until));
      CHECK(std::abs(s.velocity(0).x() - a * until) <= (scheme.order > 0.0 ? 1e-9 : 1e-7));
      CHECK(s.touching(0));
      CHECK_FALSE(s.held(0));
      CHECK(s.nodes_touching(0) == 1);
      CHECK(s.nodes_touching(1) == 1);
      // What the sides get: into them, and friction along the groove.
      CHECK(std::abs(-s.surface_force(0).dot(Vector3(0, std::sin(steep_left), std::cos(steep_left))) - left) <= 1e-6);
      CHECK(std::abs(-s.surface_force(1).dot(Vector3(0, -std::sin(steep_right), std::cos(steep_right))) - right) <=
            1e-6);
      CHECK((s.reaction(0) - mass * Vector3(a - along, 0, into)).norm() <= 1e-6);
    }
  }
}

TEST_CASE("a node thrown up a rough groove comes to rest in it and stays") {
  constexpr double mu = 0.5, speed = -1.2, h = 0.002;
  const double a = along + mu * (left + right) / mass, stops = -speed / a;
  REQUIRE(mu * (left + right) / mass > along);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(groove({Friction::Kind::coulomb, mu}, speed), scheme.integrator, h);
    s.advance_to(2.0 * stops);
    const double accuracy = scheme.order == 0.0 ? 1e-7 : scheme.order == 1.0 ? 0.6 * h * -speed : a * h * h;
    CHECK(std::abs(s.position(0).x() + 0.5 * speed * speed / a) <= accuracy);
    CHECK(s.position(0).tail<2>().norm() <= 1e-9);
    CHECK(s.held(0));
    CHECK(s.velocity(0).norm() == 0.0);
    CHECK((s.reaction(0) + mass * Vector3(along, 0, -into)).norm() <= 1e-6);
    if (scheme.order > 0.0) continue;
    double stuck = 0.0;
    for (const Event& event : s.events())
      if (event.kind == Event::Kind::stuck) stuck = event.time;
    CHECK(std::abs(stuck - stops) <= 1e-7);
  }
}

TEST_CASE("a node on a floor runs into a wall, slides along it, and is drawn off it again") {
  // Wall x = 1. The load presses it to the wall until 0.8 s, then draws it off.
  constexpr double v = 1.7, across = 0.9, press = 2.0, pull = -1.5, turns = 0.8, until = 1.3, h = 0.004;
  Network net;
  net.add_node(point({0, 0, 0}, mass, {v, across, 0}));
  net.set_gravity({0, 0.3, -g});
  net.add_load({{0}, {press, 0, 0}, 0.0, turns});
  net.add_load({{0}, {pull, 0, 0}, turns});
  net.add_plane(plane_of("floor", {0, 0, 1}, frictionless));
  net.add_plane(plane_of("wall", {-1, 0, 0}, frictionless, {1, 0, 0}));
  const double gone = until - turns;
  const Vector3 in_corner(1, across * turns + 0.15 * turns * turns, 0);
  const Vector3 end(1 + 0.5 * pull / mass * gone * gone, across * until + 0.15 * until * until, 0);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, h);
    s.advance_to(turns);
    CHECK((s.position(0) - in_corner).norm() <= allowed(scheme, h, 0.3 * turns));
    CHECK_FALSE(s.held(0));
    CHECK(s.nodes_touching(0) == 1);
    CHECK(s.nodes_touching(1) == 1);
    const double a = press / mass, hit = (-v + std::sqrt(v * v + 2.0 * a)) / a;
    CHECK(std::abs(s.contact_impulse(0).x() + mass * (v + a * hit)) <= (scheme.order > 0.0 ? 2.0 * h * press : 1e-6));
    s.advance_to(until);
    // A step may pass until it leaves.
    CHECK((s.position(0) - end).norm() <=
          (scheme.order > 0.0 ? 1.1 * h * (-pull / mass * gone) + 0.51 * h * 0.3 * until : 1e-7));
    CHECK(s.nodes_touching(1) == 0);
    CHECK(std::abs(s.position(0).z()) <= 1e-12);
  }
}

TEST_CASE("where three planes meet a node stops, and leaves along two of them when it is drawn out") {
  constexpr double h = 0.004, stop = 0.5, turns = 1.0, pull = 8.0, until = 1.4;  // m, s, N
  Network net = groove(frictionless, 0.0);
  net.add_plane(plane_of("end", {-1, 0, 0}, frictionless, {stop, 0, 0}));
  net.add_load({{0}, {-pull, 0, 0}, turns});
  const double out = pull / mass - along;
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, h);
    s.advance_to(turns);
    CHECK((s.position(0) - Vector3(stop, 0, 0)).norm() <= 1e-9);
    CHECK(s.velocity(0).norm() <= 1e-12);
    CHECK((s.reaction(0) + mass * net.gravity()).norm() <= 1e-6);
    for (const std::size_t surface : {0u, 1u, 2u}) CHECK(s.nodes_touching(surface) == 1);
    CHECK(std::abs(s.surface_force(2).x() - mass * along) <= 1e-6);
    s.advance_to(until);
    const double gone = until - turns;
    CHECK((s.position(0) - Vector3(stop - 0.5 * out * gone * gone, 0, 0)).norm() <=
          (scheme.order > 0.0 ? 1.1 * h * out * gone : 1e-7));
  }
}

TEST_CASE("between a plane and a sphere a node slides round the circle where they meet, and leaves the sphere") {
  // In the plane it is the way off a circle of radius 0.8 m: it leaves where cos = 2/3 of the start's.
  constexpr double from = 0.1, radius = 0.8, h = 0.002;
  Network net;
  net.add_node(point({radius * std::cos(from), radius * std::sin(from), 0}, mass));
  net.set_gravity({-1, 0, -3});
  net.add_plane(plane_of("floor", {0, 0, 1}, frictionless));
  Instrument sphere;
  sphere.first = sphere.second = {0, 0, 0.6};
  sphere.friction = frictionless;
  net.add_instrument(sphere);
  const double to = std::acos(2.0 / 3.0 * std::cos(from)), leaves = std::sqrt(radius) * time_on_sphere(from, to);
  const double speed = std::sqrt(radius * std::cos(to)), later = 0.1;
  const Vector3 end = radius * Vector3(std::cos(to), std::sin(to), 0) +
                      later * speed * Vector3(-std::sin(to), std::cos(to), 0) - Vector3(0.5 * later * later, 0, 0);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, h);
    double pull = 0.0;
    while (s.time() < leaves + later - 0.5 * h) {
      if (s.time() + 1.5 * h > leaves + later)
        s.advance_to(leaves + later);
      else
        s.step();
      if (s.nodes_touching(1) == 0) continue;
      const Vector3 normal = (s.position(0) - sphere.first).normalized();
      pull = std::max(pull, normal.dot(s.surface_force(1)));
    }
    CHECK(pull <= 1e-9);
    CHECK((s.position(0) - end).norm() <= (scheme.order == 1.0 ? 3.0 * h : scheme.order == 2.0 ? 10.0 * h * h : 1e-6));
    CHECK(s.nodes_touching(0) == 1);
    CHECK(s.nodes_touching(1) == 0);
    std::size_t released = 0;
    for (const Event& event : s.events()) released += event.kind == Event::Kind::released ? 1 : 0;
    CHECK(released == 1);
  }
}

namespace {

// Planes that meet in a point; a node that falls among them.
Network pyramid(int count, double mu, double aside = 0.0) {
  Network net;
  net.add_node(point({0.04 + aside, -0.02, 0.3}, mass, {0.9, 0.7, -0.4}));
  Node far = point({0.3, 0.1, 1.0});
  far.fixed = true;
  net.add_node(far);
  net.add_spring(0, 1, net.add_material(damped(12.0, 2.0)));
  net.set_gravity({1.0, -2.0, -g});
  for (int i = 0; i < count; ++i) {
    const double turn = 2.0 * std::numbers::pi * (i + 0.3 * std::sin(5.1 * i)) / count;
    const double slope = 0.7 + 0.15 * std::sin(3.7 * i);
    const Vector3 normal(-std::cos(turn) * std::sin(slope), -std::sin(turn) * std::sin(slope), std::cos(slope));
    const Friction friction = mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless;
    net.add_plane(plane_of(("side " + std::to_string(i)).c_str(), normal, friction));
  }
  return net;
}

}  // namespace

// Of planes that meet in a point three decide at most where a node goes, which are others as it goes on.
TEST_CASE("a node that falls into a pyramid of many planes stays before all of them, and comes to rest") {
  constexpr double h = 0.005, until = 3.0;
  std::vector<Scheme> schemes = stepping_schemes(1e-9);
  for (const double theta : {1.0, 0.5})
    schemes.push_back({"located", recurrent(newton, 1e-9, {{"theta", theta}, {"events", 1.0}}), 2.0});
  for (const int count : {8, 13}) {
    for (const double mu : {0.0, 0.3}) {
      const Network net = pyramid(count, mu);
      for (const Scheme& scheme : schemes) {
        INFO(scheme.name << ", " << count << " planes, friction " << mu);
        Simulation s = simulate(net, scheme.integrator, h);
        double behind = 0.0;
        while (s.time() < until && steps_on(s))
          for (const Plane& plane : net.planes()) behind = std::max(behind, -plane.normal.dot(s.position(0)));
        // Rounding; located events find a touch up to 1e-9 of a length after it.
        CHECK(behind <= (scheme.name == "located" ? 1e-9 : 1e-14));
        CHECK(s.kinetic_energy() <= 1e-3);
      }
    }
  }
}

// On its way down an edge the node meets all other planes at once, at the vertex: what comes first is no matter of
// rounding, which differs between these starts.
TEST_CASE("a node settles at the vertex of many rough planes, wherever it started") {
  constexpr double h = 0.005, until = 1.2;
  for (const double theta : {1.0, 0.5}) {
    for (const double rule : {synchronous, block, newton}) {
      for (int start = 0; start < 24; ++start) {
        INFO(update_rules[static_cast<std::size_t>(rule)] << ", theta " << theta << ", start " << start);
        Simulation s = simulate(pyramid(8, 0.3, 1e-9 * start), recurrent(rule, 1e-9, {{"theta", theta}}), h);
        while (s.time() < until && steps_on(s)) {
        }
        CHECK(s.time() >= until);
        CHECK(s.velocity(0).norm() <= 1e-9);
      }
    }
  }
}
