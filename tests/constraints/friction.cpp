// Friction on surfaces: held as in the paper, none, Coulomb's; closed forms on planes.

#include <doctest/doctest.h>

#include "constraints/friction.hpp"
#include "schemes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double gravity = 9.81;

// A node on a plane that is tilted by `angle` (rad) about y: gravity has a part along x and one into the plane z = 0.
Network on_incline(double angle, const Friction& friction, const Vector3& velocity) {
  Network net;
  net.add_node(point(Vector3::Zero(), 0.7, velocity));
  net.set_gravity({gravity * std::sin(angle), 0, -gravity * std::cos(angle)});
  Plane plane;
  plane.friction = friction;
  net.add_plane(plane);
  return net;
}

}  // namespace

TEST_CASE("on an incline a node sticks, slides or is held as friction says") {
  constexpr double angle = 0.4, time = 0.5;  // rad, s
  const double along = gravity * std::sin(angle), into = gravity * std::cos(angle);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    // Constant forces: second order is exact; first order is off by h / 2 times the speed gained.
    const double h = 0.005;
    const double accuracy = scheme.order == 1.0 ? 0.51 * h * along * time : scheme.order == 2.0 ? 1e-9 : 1e-6;
    SUBCASE("none") {
      Simulation s = simulate(on_incline(angle, {Friction::Kind::none, 0.0}, {0, 0, 0}), scheme.integrator, h);
      s.advance_to(time);
      CHECK(std::abs(s.position(0)[0] - 0.5 * along * time * time) <= accuracy);
      CHECK(std::abs(s.position(0)[2]) <= 1e-12);
      CHECK(s.touching(0));
      CHECK_FALSE(s.held(0));
      CHECK(std::abs(s.reaction(0)[2] - 0.7 * into) <= 1e-9);
      CHECK(std::abs(s.reaction(0)[0]) <= 1e-9);
    }
    SUBCASE("Coulomb, too little to hold") {
      const double mu = 0.3;  // tan(0.4) = 0.42
      Simulation s = simulate(on_incline(angle, {Friction::Kind::coulomb, mu}, {0, 0, 0}), scheme.integrator, h);
      s.advance_to(time);
      CHECK(std::abs(s.position(0)[0] - 0.5 * (along - mu * into) * time * time) <= accuracy);
      CHECK_FALSE(s.held(0));
      CHECK(std::abs(s.reaction(0)[0] + 0.7 * mu * into) <= 1e-6);
    }
    SUBCASE("Coulomb, enough to hold") {
      Simulation s = simulate(on_incline(angle, {Friction::Kind::coulomb, 0.5}, {0, 0, 0}), scheme.integrator, h);
      s.advance_to(time);
      CHECK(s.position(0).norm() <= 1e-12);
      CHECK(s.held(0));
      CHECK((s.reaction(0) + 0.7 * Vector3(along, 0, -into)).norm() <= 1e-9);
    }
    SUBCASE("held, the paper's") {
      Simulation s = simulate(on_incline(angle, {Friction::Kind::held, 0.0}, {0, 0, 0}), scheme.integrator, h);
      s.advance_to(time);
      CHECK(s.position(0).norm() <= 1e-12);
      CHECK(s.held(0));
    }
  }
}

TEST_CASE("a thrown puck slides v^2 / (2 mu g) far and stays there") {
  constexpr double mu = 0.4, speed = 1.5;
  const double far = speed * speed / (2.0 * mu * gravity);
  const Vector3 direction = Vector3(3, 4, 0) / 5.0;
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    const double h = 0.002;
    Simulation s = simulate(on_incline(0.0, {Friction::Kind::coulomb, mu}, speed * direction), scheme.integrator, h);
    s.advance_to(0.8);
    // It stops within a step: off by a step's path at the last speed, and first order by h / 2 times the first.
    const double accuracy = scheme.order == 0.0 ? 1e-6 : scheme.order == 1.0 ? 0.6 * h * speed : mu * gravity * h * h;
    CHECK((s.position(0) - far * direction).norm() <= accuracy);
    CHECK(s.held(0));
    CHECK(s.velocity(0).norm() == 0.0);
    int stuck = 0;
    for (const Event& event : s.events()) stuck += event.kind == Event::Kind::stuck ? 1 : 0;
    CHECK(stuck == 1);
  }
}

TEST_CASE("Coulomb's rule for one node: cone, slip direction, no pull, whatever the mobility") {
  Eigen::Matrix3d mobility;
  mobility << 2.0, 0.3, -0.2, 0.3, 1.5, 0.4, -0.2, 0.4, 1.0;
  const Vector3 n = Vector3(1, 2, 2) / 3.0;
  for (const double mu : {0.1, 0.5, 2.0}) {
    for (const Vector3& relative : {Vector3(-1, -2, -2), Vector3(3, 0, -2), Vector3(0.1, -4, 1), Vector3(1, 1, 1)}) {
      CAPTURE(mu);
      CAPTURE(relative[0]);
      const ContactResponse answer = solve_contact(mobility, relative, n, {Friction::Kind::coulomb, mu});
      // Impulse and velocity belong together.
      CHECK((answer.velocity - relative - mobility * answer.impulse).norm() <= 1e-12);
      if (answer.normal < 0.0) {
        CHECK(n.dot(relative) > 0.0);  // it leaves: the caller lets it go
        continue;
      }
      CHECK(std::abs(n.dot(answer.velocity)) <= 1e-12);
      const double pressing = n.dot(answer.impulse);
      const Vector3 along = answer.impulse - pressing * n;
      CHECK(along.norm() <= mu * pressing * (1.0 + 1e-9));
      if (answer.sticks) {
        CHECK(answer.velocity.norm() <= 1e-12);
      } else {
        // On the edge of the cone, against the slip that is left.
        CHECK(along.norm() == doctest::Approx(mu * pressing).epsilon(1e-9));
        CHECK(along.dot(answer.velocity) == doctest::Approx(-along.norm() * answer.velocity.norm()).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE(
    "a dumbbell with rigid rod lands on a floor without friction and slides on, its momentum along the floor kept") {
  Network net;
  net.add_node(point({0, 0, 0.3}, 0.5, {0.8, 0, 0}));
  net.add_node(point({0.6, 0, 0.7}, 1.0, {0.8, 0, 0}));
  net.add_rigid(0, 1);
  net.set_gravity({0, 0, -gravity});
  Plane plane;
  plane.friction.kind = Friction::Kind::none;
  net.add_plane(plane);
  Simulation reference = simulate(net, cvode(1e-10), 0.01);
  reference.advance_to(0.35);
  REQUIRE(reference.touching(0));
  for (const Scheme& scheme : stepping_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, 0.001);
    s.advance_to(0.35);
    CHECK(s.touching(0));
    CHECK(worst_length(net, s) <= 1e-8);
    // Nothing pushes along the floor.
    CHECK(std::abs(s.momentum()[0] - 1.2) <= 1e-9);
    // The touch falls within a step, of 1 ms at 2.4 m/s: off by a part of that distance in all that follows.
    CHECK(distance(s, reference) <= 2.4e-3);
  }
}

TEST_CASE("a node that slides into a second surface stops there, in every integrator, and leaves it again") {
  // On the floor z = 0 towards the wall x = 0.2, from 0.5 s on pulled away from it again.
  Network net;
  net.add_node(point(Vector3::Zero(), 0.7, {0.9, 0, 0}));
  net.add_node(point({0.05, 1, 0}, 0.7, {0.9, 0, 0}));
  net.set_gravity({0, 0, -gravity});
  Plane floor, wall;
  floor.friction = wall.friction = {Friction::Kind::none, 0.0};
  wall.point = {0.2, 0, 0};
  wall.normal = {-1, 0, 0};
  net.add_plane(floor);
  net.add_plane(wall);
  SUBCASE("two planes") {}
  SUBCASE("two planes, the nodes joined rigidly") { net.add_rigid(0, 1); }
  constexpr double pull = 1.4, from = 0.5, until = 0.8, h = 0.005;
  net.add_load({{0, 1}, {-pull, 0, 0}, from});
  const bool rigid = !net.rigids().empty();
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, h);
    s.advance_to(0.45);
    // Joined to another node it is drawn back a little by that one, which swings round it: by less than a millimetre in
    // the reference. On a wall that it went through it would be at 0.45.
    CHECK(std::abs(s.position(1)[0] - 0.2) <= (rigid ? 1e-3 : 1e-9));
    if (!rigid) CHECK(std::abs(s.position(0)[0] - 0.2) <= 1e-9);
    CHECK(std::abs(s.position(1)[2]) <= 1e-9);
    CHECK(s.touching(1));
    s.advance_to(until);
    const double moved = 0.5 * pull / 0.7 * (until - from) * (until - from);
    CHECK(std::abs(s.position(1)[2]) <= 1e-9);
    if (rigid) continue;  // the other node went on around the stopped one
    // First order: h / 2 times the speed gained; the step in which it leaves may be lost.
    const double accuracy = scheme.order > 0.0 ? 1.6 * h * pull / 0.7 * (until - from) : 1e-6;
    CHECK(std::abs(0.2 - moved - s.position(1)[0]) <= accuracy);
    CHECK(std::abs(0.2 - moved - s.position(0)[0]) <= accuracy);
  }
}

TEST_CASE("a node that came to a corner leaves it again, whichever surface it met first") {
  // Without friction: driven by 20 N/kg into the corner of floor and wall, then by -8 N/kg out of it from 0.7 s on.
  const Friction none{Friction::Kind::none, 0.0};
  for (const double height : {0.0, 0.5}) {
    Network net;
    net.add_node(point({0.5, 0, height}, 1.0, {2, 0, 0}));
    net.set_gravity({0, 0, -9.81});
    net.add_load({{0}, {20, 0, 0}, 0.0, 0.7});
    net.add_load({{0}, {-8, 0, 0}, 0.7, 10.0});
    net.add_plane({"floor", {0, 0, 0}, {0, 0, 1}, none});
    net.add_plane({"wall", {1, 0, 0}, {-1, 0, 0}, none});
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name << ", from " << height);
      Simulation simulation = simulate(net, scheme.integrator, 0.0025);
      simulation.advance_to(1.5);
      CHECK(std::abs(simulation.position(0).z()) <= 1e-12);
      // 1 - 4 t^2 after 0.8 s; steps leave late by up to two of them.
      CHECK(simulation.position(0).x() == doctest::Approx(1.0 - 4.0 * 0.64).epsilon(scheme.order > 0.0 ? 0.01 : 1e-6));
    }
  }
}

TEST_CASE("a corner whose wall moves lets its node go, or pushes it along, whichever surface it met first") {
  // Pressed to floor and wall by 1 N; from 1 s on the wall goes 0.5 m away within 1 s, or comes as much nearer.
  const Friction none{Friction::Kind::none, 0.0};
  for (const double wall_displacement : {0.5, -0.5}) {
    for (const bool floor_last : {false, true}) {
      Network net;
      net.add_node(floor_last ? point({1, 0, 0.3}) : point({0.9, 0, 0}));
      net.set_gravity({0, 0, -9.81});
      net.add_load({{0}, {1, 0, 0}});
      net.add_plane({"floor", {0, 0, 0}, {0, 0, 1}, none});
      Motion motion;
      motion.times = {1.0, 2.0};
      motion.displacements = {Vector3::Zero(), {wall_displacement, 0, 0}};
      net.add_plane({"wall", {1, 0, 0}, {-1, 0, 0}, none, motion});
      Simulation simulation = simulate(net, cvode(1e-9), 0.05);
      CAPTURE(wall_displacement);
      CAPTURE(floor_last);
      simulation.advance_to(0.95);
      CHECK(simulation.position(0).x() == doctest::Approx(1.0).epsilon(1e-9));
      simulation.advance_to(3.0);
      CHECK(std::abs(simulation.position(0).z()) <= 1e-7);
      // Pushed it stays at the wall; drawn away it follows with 1 m/s^2 at most: 0.5 t^2, and the wall comes to rest.
      CHECK(simulation.position(0).x() == doctest::Approx(1.0 + wall_displacement).epsilon(1e-6));
    }
  }
}

TEST_CASE("a node that friction holds in a corner makes no events without end") {
  Network net;
  const Friction rough{Friction::Kind::coulomb, 0.3};
  net.add_node(point({0.9, 0, 0}, 1.0, {2, 0, 0}));
  net.set_gravity({0, 0, -9.81});
  net.add_load({{0}, {4, 0, 0}});
  net.add_plane({"floor", {0, 0, 0}, {0, 0, 1}, rough});
  net.add_plane({"wall", {1, 0, 0}, {-1, 0, 0}, rough});
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation simulation = simulate(net, scheme.integrator, 0.01);
    simulation.advance_to(0.4);
    CHECK((simulation.position(0) - Vector3(1, 0, 0)).norm() <= 1e-9);
    CHECK(simulation.events().size() < 12);
  }
}

TEST_CASE("on two surfaces that are flush with each other a node slides as on one") {
  // It falls onto both, loses mu times its fall's speed, and is slowed by mu g.
  constexpr double g = 9.81, mu = 0.1, fall = 0.01, until = 0.3;
  Network net;
  net.add_node(point({0, 0, fall}, 1.0, {1, 0, 0}));
  net.set_gravity({0, 0, -g});
  Plane floor;
  floor.friction = {Friction::Kind::coulomb, mu};
  net.add_plane(floor);
  Instrument tile;
  tile.first = {0, 0, -0.5};
  tile.box = BoxShape{{10, 10, 1}, Eigen::Matrix3d::Identity(), 0.0};
  tile.friction = floor.friction;
  net.add_instrument(tile);
  const double expected = 1.0 - mu * g * until;  // the blow's share and the flight's make up for each other
  for (const Scheme& scheme : all_schemes(1e-9)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, 0.004);
    s.advance_to(until);
    CHECK(std::abs(s.velocity(0).x() - expected) <= (scheme.order > 0.0 ? 2.0 * mu * g * 0.004 : 1e-7));
  }
}
