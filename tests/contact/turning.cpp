// Surfaces that turn about an axis.

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double g = 9.81, mass = 0.6, rate = 1.7;  // m/s^2, kg, rad/s

Vector3 turned(const Vector3& p, double angle, const Vector3& axis) { return Eigen::AngleAxisd(angle, axis) * p; }

Network on_turntable(const Friction& friction, const Vector3& place, const Vector3& velocity) {
  Network net;
  net.add_node(point(place, mass, velocity));
  net.set_gravity({0, 0, -g});
  Plane plane;
  plane.friction = friction;
  plane.turn.emplace();
  plane.turn->rate = rate;
  net.add_plane(plane);
  return net;
}

// A node on top of a sphere, or of a box, of which it is `radius` from the axis y.
Network on_roller(const Friction& friction, double radius, bool box) {
  Network net;
  net.add_node(point({0, 0, radius}, mass, {rate * radius, 0, 0}));
  net.set_gravity({0, 0, -g});
  Instrument roller;
  roller.radius = radius;
  roller.friction = friction;
  roller.turn.emplace();
  roller.turn->axis = {0, 2, 0};
  roller.turn->rate = rate;
  if (box) {
    roller.box.emplace();
    roller.box->size = {3, 1, 2.0 * radius};
  }
  net.add_instrument(roller);
  return net;
}

}  // namespace

TEST_CASE("a turntable carries a sticking node with it, and supplies the centripetal force") {
  const Vector3 place(0.5, 0.2, 0), velocity = rate * Vector3::UnitZ().cross(place);
  const double until = 1.1;
  for (const Friction& friction : {Friction{Friction::Kind::held, 0.0}, Friction{Friction::Kind::coulomb, 0.2}}) {
    REQUIRE(rate * rate * place.norm() < 0.2 * g);
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name << ", friction " << static_cast<int>(friction.kind));
      Simulation s = simulate(on_turntable(friction, place, velocity), scheme.integrator, 0.005);
      if (!reaches(s, until)) continue;
      const double accuracy = scheme.order > 0.0 ? 1e-9 : 1e-6;
      const Vector3 now = turned(place, rate * until, Vector3::UnitZ());
      CHECK((s.position(0) - now).norm() <= accuracy);
      CHECK((s.velocity(0) - rate * Vector3::UnitZ().cross(now)).norm() <= accuracy);
      CHECK(s.held(0));
      const Vector3 reaction = mass * (Vector3(0, 0, g) - rate * rate * now);
      CHECK((s.reaction(0) - reaction).norm() <= (scheme.order > 0.0 ? 0.01 * reaction.norm() : 1e-6));
      CHECK((s.surface_force(0) + s.reaction(0)).norm() <= 1e-12);
      CHECK((s.surface_torque(0) + s.position(0).cross(s.reaction(0))).norm() <= 1e-9);
      CHECK((s.surface_spin(0) - Vector3(0, 0, rate)).norm() <= 1e-12);
      CHECK((s.surface_rotation(0) * place - now).norm() <= 1e-12);
      const auto touching = s.surfaces_of(0);
      CHECK(touching.size() == 1);
    }
  }
}

TEST_CASE("a node at rest on a turntable is dragged along by friction against its slip") {
  constexpr double mu = 0.05, until = 0.6;
  const Vector3 place(0.9, -0.3, 0);
  // v' = -mu g u / |u|, u = v - w x p; by Runge and Kutta's method of fourth order.
  Vector3 p = place, v = Vector3::Zero();
  const auto acceleration = [&](const Vector3& x, const Vector3& y) -> Vector3 {
    return -mu * g * (y - rate * Vector3::UnitZ().cross(x)).normalized();
  };
  constexpr int steps = 6000;
  const double dt = until / steps;
  for (int i = 0; i < steps; ++i) {
    const Vector3 a1 = acceleration(p, v), v2 = v + dt / 2 * a1, a2 = acceleration(p + dt / 2 * v, v2);
    const Vector3 v3 = v + dt / 2 * a2, a3 = acceleration(p + dt / 2 * v2, v3);
    const Vector3 v4 = v + dt * a3, a4 = acceleration(p + dt * v3, v4);
    p += dt / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  REQUIRE((v - rate * Vector3::UnitZ().cross(p)).norm() > 0.3);
  const Network net = on_turntable({Friction::Kind::coulomb, mu}, place, Vector3::Zero());
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    double error[2];
    for (const int halving : {0, 1}) {
      Simulation s = simulate(net, scheme.integrator, halving == 0 ? 0.01 : 0.005);
      if (!reaches(s, until)) continue;
      error[halving] = (s.position(0) - p).norm();
      CHECK_FALSE(s.held(0));
    }
    if (scheme.order == 0.0)
      CHECK(error[1] <= 1e-6);
    else
      CHECK(std::log2(error[0] / error[1]) > scheme.order - 0.2);
  }
}

TEST_CASE("a roller carries a held node over until it would have to pull, and throws it off") {
  // N = m (g cos - w^2 R) along the normal; then free flight with w R.
  for (const bool box : {false, true}) {
    const double radius = 0.8, angle = std::acos(rate * rate * radius / g), release_time = angle / rate, later = 0.15;
    const Vector3 place = turned({0, 0, radius}, angle, Vector3::UnitY());
    const Vector3 velocity = rate * Vector3::UnitY().cross(place);
    const Vector3 end = place + later * velocity - Vector3(0, 0, 0.5 * g * later * later);
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name << (box ? ", box" : ", sphere"));
      const double h = 0.001;
      Simulation s = simulate(on_roller({Friction::Kind::held, 0.0}, radius, box), scheme.integrator, h);
      double pull = 0.0;
      while (s.time() < release_time + later - 0.5 * h && steps_on(s)) {
        if (s.time() + 1.5 * h > release_time + later && !reaches(s, release_time + later)) break;
        const Vector3 normal = turned(Vector3::UnitZ(), rate * s.time(), Vector3::UnitY());
        if (s.touching(0)) pull = std::max(pull, -normal.dot(s.reaction(0)));
      }
      CHECK(pull <= 1e-9);
      // A step late it is carried on: h times the speed; first order loses g t h / 2 in the flight.
      CHECK((s.position(0) - end).norm() <= (scheme.order == 1.0 ? 3.0 * h : scheme.order == 2.0 ? 5.0 * h : 1e-6));
      std::vector<double> released;
      for (const Event& event : s.events())
        if (event.kind == Event::Kind::released) released.push_back(event.time);
      CHECK(released.size() == 1);
      if (!released.empty()) CHECK(std::abs(released[0] - release_time) <= (scheme.order > 0.0 ? 2.0 * h : 1e-7));
    }
  }
}

TEST_CASE("on a roller with friction a node slips where the slope is too steep for its cone") {
  constexpr double mu = 0.4, radius = 0.8;
  double below = 0.0, above = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double angle = 0.5 * (below + above);
    (g * std::sin(angle) < mu * (g * std::cos(angle) - rate * rate * radius) ? below : above) = angle;
  }
  const double slips = below / rate;
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    const double h = 0.0005;
    Simulation s = simulate(on_roller({Friction::Kind::coulomb, mu}, radius, false), scheme.integrator, h);
    if (!reaches(s, slips + 0.02)) continue;
    double slipped = 0.0;
    for (const Event& event : s.events())
      if (event.kind == Event::Kind::slipped && slipped == 0.0) slipped = event.time;
    CHECK(std::abs(slipped - slips) <= (scheme.order > 0.0 ? 2.0 * h : 1e-7));
  }
}

TEST_CASE("on a plane that tilts at a constant rate a node slides as in the closed form") {
  // In the plane's frame r'' = w^2 r + g sin(w t), N = m (g cos(w t) - 2 w r').
  constexpr double w = 0.9, r0 = 0.3, speed = -0.2, until = 0.5;
  const double b = speed + 0.5 * g / w;  // of r = A cosh + B / w sinh - g / (2 w^2) sin
  const double r = r0 * std::cosh(w * until) + b / w * std::sinh(w * until) - 0.5 * g / (w * w) * std::sin(w * until);
  const double rr = w * r0 * std::sinh(w * until) + b * std::cosh(w * until) - 0.5 * g / w * std::cos(w * until);
  const Vector3 end = r * Vector3(std::cos(w * until), 0, -std::sin(w * until));
  Network net;
  net.add_node(point({r0, 0.1, 0}, mass, {speed, 0, -w * r0}));
  net.set_gravity({0, 0, -g});
  Plane plane;
  plane.friction = frictionless;
  plane.turn.emplace();
  plane.turn->axis = Vector3::UnitY();
  plane.turn->rate = w;
  net.add_plane(plane);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    double error[2];
    for (const int halving : {0, 1}) {
      Simulation s = simulate(net, scheme.integrator, halving == 0 ? 0.01 : 0.005);
      if (!reaches(s, until)) continue;
      error[halving] = (s.position(0) - end - Vector3(0, 0.1, 0)).norm();
      const double normal = Vector3(std::sin(w * until), 0, std::cos(w * until)).dot(s.reaction(0));
      const double expected = mass * (g * std::cos(w * until) - 2.0 * w * rr);
      CHECK(std::abs(normal - expected) <= (scheme.order > 0.0 ? 0.02 * expected : 1e-5));
    }
    if (scheme.order == 0.0)
      CHECK(error[1] <= 1e-6);
    else
      CHECK(std::log2(error[0] / error[1]) > scheme.order - 0.2);
  }
}
