// Surfaces that turn as tables say and move besides, and a box that hits, in every integrator.

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "schemes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Vector3 turned(const Vector3& axis, double angle, const Vector3& x) { return Eigen::AngleAxisd(angle, axis) * x; }

}  // namespace

TEST_CASE("a turntable carries the nodes that it holds, with the forces and the torque of that motion") {
  // 0 to 2 rad in 1 s: an angle 2 (3 s^2 - 2 s^3), about an axis beside the plane's point that moves along.
  const Vector3 start(0.4, 0.1, 0), axle(0.1, -0.2, 0);
  for (const Friction& friction : {Friction{Friction::Kind::held, 0.0}, Friction{Friction::Kind::coulomb, 0.9}}) {
    Network net;
    net.add_node(point(start, 0.5));
    net.set_gravity({0, 0, -9.81});
    Plane table;
    table.friction = friction;
    table.turn.emplace();
    table.turn->through = axle;
    table.turn->times = {0, 1};
    table.turn->angles = {0, 2};
    table.motion.emplace();
    table.motion->times = {0, 1};
    table.motion->displacements = {Vector3::Zero(), Vector3(0.3, 0, 0)};
    net.add_plane(table);
    for (const Scheme& scheme : all_schemes(1e-9)) {
      INFO(scheme.name);
      // CVODE integrates what is held, to its tolerance, 1e-9 times some tens of steps.
      const bool reference = scheme.order == 0.0;
      const double exact = reference ? 2e-7 : 1e-12, balanced = reference ? 5e-7 : 1e-9;
      Simulation s = simulate(net, scheme.integrator, 0.01);
      for (const double t : {0.3, 0.7, 1.0, 1.2}) {
        s.advance_to(t);
        const double u = std::min(t, 1.0), share = u * u * (3 - 2 * u);
        const double angle = 2 * share, rate = 2 * (6 * u - 6 * u * u);
        const double acceleration = t > 1.0 ? 0.0 : 2 * (6 - 12 * u);
        const Vector3 shift(0.3 * share, 0, 0), arm = turned(Vector3::UnitZ(), angle, start - axle);
        CHECK((s.position(0) - (axle + shift + arm)).norm() <= exact);
        const Vector3 spin(0, 0, rate), velocity = Vector3(0.15 * rate, 0, 0) + spin.cross(arm);
        CHECK((s.velocity(0) - velocity).norm() <= exact);
        CHECK(s.surface_rotation(0).isApprox(Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix(), 1e-14));
        if (t == 1.0) continue;  // the acceleration jumps there
        CHECK((s.surface_spin(0) - spin).norm() <= 1e-12);
        const Vector3 bends =
            Vector3(0.15 * acceleration, 0, 0) + acceleration * Vector3::UnitZ().cross(arm) - rate * rate * arm;
        const Vector3 reaction = 0.5 * (bends + Vector3(0, 0, 9.81));
        CHECK((s.reaction(0) - reaction).norm() <= balanced);
        const Vector3 about = axle + shift + turned(Vector3::UnitZ(), angle, -axle);
        CHECK((s.surface_position(0) - about).norm() <= 1e-12);
        CHECK((s.surface_torque(0) + (s.position(0) - about).cross(reaction)).norm() <= balanced);
      }
      CHECK(s.held(0));
      CHECK(s.surfaces_of(0) == std::vector<std::size_t>{0});
    }
  }
}

TEST_CASE("a host moves a surface that turns: it arrives where the host says, and goes on turning") {
  Network net;
  net.add_node(point(Vector3::Zero()));
  Instrument ball;
  ball.first = {5, 0, 0};
  ball.second = {6, 0, 0};
  ball.turn.emplace();
  ball.turn->through = Vector3(4, 0, 0);
  ball.turn->rate = 2.0;
  net.add_instrument(ball);
  Simulation s = simulate(net, recurrent(newton, 1e-9), 0.01);
  s.advance_to(0.2);
  CHECK((s.surface_position(0) - Vector3(4 + std::cos(0.4), std::sin(0.4), 0)).norm() <= 1e-14);
  CHECK((s.surface_velocity(0) - Vector3(-2 * std::sin(0.4), 2 * std::cos(0.4), 0)).norm() <= 1e-14);
  s.move_surface(0, {7, 1, 2}, 0.5);
  CHECK((s.surface_position(0) - Vector3(4 + std::cos(0.4), std::sin(0.4), 0)).norm() <= 1e-14);  // not at once
  s.advance_to(0.5);
  CHECK((s.surface_position(0) - Vector3(7, 1, 2)).norm() <= 1e-12);
  CHECK(s.surface_rotation(0).isApprox(Eigen::AngleAxisd(1.0, Vector3::UnitZ()).toRotationMatrix(), 1e-12));
  CHECK(s.surface_spin(0) == Vector3(0, 0, 2.0));
}

TEST_CASE("a paddle hits a node and takes it out along itself") {
  // Its face reaches the node at angle a; from there r'' = w^2 r.
  const double w = 2.0, half = 0.1, height = 0.5;
  Network net;
  net.add_node(point({0.8, height, 0}, 0.3));
  Instrument paddle;
  paddle.friction = frictionless;
  paddle.box.emplace();
  paddle.box->size = {4.0, 2 * half, 1.0};
  paddle.turn.emplace();
  paddle.turn->rate = w;
  net.add_instrument(paddle);
  const double distance = std::hypot(0.8, height), angle = std::atan2(height, 0.8) - std::asin(half / distance);
  const double met = angle / w, r0 = std::sqrt(distance * distance - half * half), end = met + 0.3;
  // On the face, `half` above the middle, the node stays at the height and goes out as r0 cosh(w t): at the touch its
  // velocity along the paddle, seen from it, is w half against it and 0 in space.
  const auto r = [&](double t) { return r0 * std::cosh(w * t) + half * std::sinh(w * t); };
  const Vector3 along(std::cos(w * end), std::sin(w * end), 0), across(-std::sin(w * end), std::cos(w * end), 0);
  REQUIRE(r(end - met) < 2.0);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, 0.001);
    s.advance_to(end);
    REQUIRE(s.touching(0));
    CHECK(across.dot(s.position(0)) == doctest::Approx(half).epsilon(1e-9));
    // The touch falls within a step, which begins with the velocity before: 1 ms of up to 2 m/s.
    CHECK(std::abs(along.dot(s.position(0)) - r(end - met)) <= (scheme.order > 0.0 ? 2.5e-3 : 1e-6));
    // The blow: the velocity of the face there, across it.
    const Vector3 n(-std::sin(angle), std::cos(angle), 0);
    CHECK((s.contact_impulse(0) - 0.3 * w * r0 * n).norm() <= (scheme.order > 0.0 ? 5e-3 : 1e-6));
  }
}
