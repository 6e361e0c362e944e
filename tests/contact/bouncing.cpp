// Restitution: Newton's law at each touch, with Coulomb's cone along the surface.

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double g = 9.81, height = 0.5, share = 0.8, mass = 0.7;  // m/s^2, m, 1, kg

Network dropped(const Friction& friction, double along) {
  Network net;
  net.add_node(point({0, 0, height}, mass, {along, 0, 0}));
  net.set_gravity({0, 0, -g});
  Plane plane;
  plane.friction = friction;
  plane.restitution = share;
  net.add_plane(plane);
  return net;
}

// Height, and the place along the plane where each bounce takes mu times the change of the speed across. m
Vector3 flight(double time, double along, double mu) {
  double fall = std::sqrt(2.0 * height / g), up = std::sqrt(2.0 * g * height), x = 0.0;
  if (time <= fall) return {along * time, 0, height - 0.5 * g * time * time};
  x = along * fall;
  time -= fall;
  while (true) {
    along = std::max(0.0, along - mu * (1.0 + share) * up);
    up *= share;
    const double lasts = 2.0 * up / g;
    if (time <= lasts) return {x + along * time, 0, up * time - 0.5 * g * time * time};
    x += along * lasts;
    time -= lasts;
  }
}

}  // namespace

TEST_CASE("a dropped ball bounces as high as its coefficient says") {
  const double first = std::sqrt(2.0 * height / g);
  for (const double mu : {0.0, 0.1}) {
    const Friction friction = mu > 0.0 ? Friction{Friction::Kind::coulomb, mu} : frictionless;
    const double along = 2.5, until = 1.7;  // after four bounces
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name << ", friction " << mu);
      const double h = 0.001;
      Simulation s = simulate(dropped(friction, along), scheme.integrator, h);
      if (!reaches(s, until)) continue;
      // A touch within a step is off by up to h at 3.1 m/s, each time; the falls of first order by g t h / 2.
      CHECK((s.position(0) - flight(until, along, mu)).norm() <= (scheme.order > 0.0 ? 15.0 * h : 1e-6));
      std::vector<double> touched;
      Vector3 impulse = Vector3::Zero();
      for (const Event& event : s.events()) {
        if (event.kind == Event::Kind::touched) touched.push_back(event.time);
        impulse += event.impulse;
      }
      CHECK(touched.size() == 4);
      if (touched.size() != 4) continue;
      double time = first, up = std::sqrt(2.0 * g * height);
      for (const double t : touched) {
        // First order loses up to g h at each touch, and with it up to 2 h of the flight.
        CHECK(std::abs(t - time) <= (scheme.order == 1.0 ? 20.0 * h : scheme.order == 2.0 ? 6.0 * h : 1e-7));
        up *= share;
        time += 2.0 * up / g;
      }
      CHECK((impulse - s.contact_impulse(0)).norm() <= 1e-9);
      CHECK((s.surface_impulse(0) + s.contact_impulse(0)).norm() <= 1e-9);
      const Vector3 given = mass * (s.velocity(0) - Vector3(along, 0, 0) + Vector3(0, 0, g * until));
      if (scheme.order == 0.0) CHECK((given - s.contact_impulse(0)).norm() <= 1e-7);
    }
  }
}

TEST_CASE("bounces without end come to an end, and the ball lies on the floor") {
  const double ends = std::sqrt(2.0 * height / g) * (1.0 + share) / (1.0 - share);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(dropped(frictionless, 0.3), scheme.integrator, 0.002);
    if (!reaches(s, ends + 0.3)) continue;
    CHECK(s.touching(0));
    CHECK(std::abs(s.position(0).z()) <= 1e-9);
    CHECK(std::abs(s.velocity(0).z()) <= 1e-9);
    CHECK(s.events().size() < 400);
    CHECK(s.reaction(0).z() == doctest::Approx(mass * g).epsilon(1e-6));
    // It slid on meanwhile.
    CHECK(std::abs(s.position(0).x() - 0.3 * (ends + 0.3)) <= 1e-9);
  }
}

TEST_CASE("a ball bounces off a plane that comes towards it with twice its speed more") {
  // Up at w: v' = w + e (w - v).
  constexpr double w = 0.9;
  Network net = dropped(frictionless, 0.0);
  Network moving;
  moving.set_gravity({0, 0, 0});
  moving.add_node(point({0, 0, height}, mass, {0.2, 0, -1.1}));
  Plane plane = net.planes()[0];
  plane.motion.emplace();
  plane.motion->interpolation = Motion::Interpolation::linear;
  plane.motion->times = {0.0, 10.0};
  plane.motion->displacements = {Vector3::Zero(), {0, 0, 10.0 * w}};
  moving.add_plane(plane);
  const double meets = height / (w + 1.1), speed = w + share * (w + 1.1), until = 0.5;
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    const double h = 0.002;
    Simulation s = simulate(moving, scheme.integrator, h);
    if (!reaches(s, until)) continue;
    CHECK((s.velocity(0) - Vector3(0.2, 0, speed)).norm() <= (scheme.order > 0.0 ? 1e-9 : 1e-7));
    CHECK(std::abs(s.position(0).z() - (w * meets + speed * (until - meets))) <= (scheme.order > 0.0 ? 4.0 * h : 1e-7));
  }
}

TEST_CASE("a ball leaves a sphere as light a mirror where nothing is lost") {
  Network net;
  const Vector3 from(-2, 0.3, 0.5), velocity(2, 0.1, -0.2);
  net.add_node(point(from, mass, velocity));
  Instrument sphere;
  sphere.friction = frictionless;
  sphere.restitution = 1.0;
  net.add_instrument(sphere);
  const double b = from.dot(velocity), v2 = velocity.squaredNorm();
  const double hits = (-b - std::sqrt(b * b - v2 * (from.squaredNorm() - 1.0))) / v2;
  const Vector3 n = from + hits * velocity, reflected = velocity - 2.0 * n.dot(velocity) * n;
  const double until = 1.5;
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    const double h = 0.001;
    Simulation s = simulate(net, scheme.integrator, h);
    if (!reaches(s, until)) continue;
    CHECK((s.velocity(0) - reflected).norm() <= (scheme.order > 0.0 ? 10.0 * h : 1e-6));
    CHECK((s.position(0) - n - (until - hits) * reflected).norm() <= (scheme.order > 0.0 ? 15.0 * h : 1e-6));
    CHECK(std::abs(s.kinetic_energy() - 0.5 * mass * v2) <= (scheme.order > 0.0 ? 1e-6 : 1e-7));
  }
}

TEST_CASE("a node that slides on a floor bounces off a wall and slides on; each obstacle gets its own impulse") {
  constexpr double speed = 1.0, far = 0.3, elastic = 0.8, h = 0.002;
  Network net;
  net.add_node(point({0, 0, 0}, 0.5, {speed, 0.4, 0}));
  net.set_gravity({0, 0, -9.81});
  Plane floor, wall;
  floor.name = "floor";
  floor.friction = wall.friction = frictionless;
  wall.point = {far, 0, 0};
  wall.normal = {-1, 0, 0};
  wall.restitution = elastic;
  net.add_plane(floor);
  net.add_plane(wall);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, h);
    s.advance_to(0.7);
    const double back = far - elastic * speed * (0.7 - far / speed);
    // The blow may fall anywhere within its step.
    CHECK((s.position(0) - Vector3(back, 0.28, 0)).norm() <= (scheme.order > 0.0 ? 2.0 * h * speed : 1e-7));
    CHECK((s.velocity(0) - Vector3(-elastic * speed, 0.4, 0)).norm() <= 1e-7);
    CHECK(s.touching(0));
    CHECK(s.nodes_touching(0) == 1);
    CHECK(s.nodes_touching(1) == 0);
    const Vector3 blow(-0.5 * speed * (1.0 + elastic), 0, 0);
    CHECK((s.surface_impulse(1) + blow).norm() <= 1e-7);
    std::size_t touched = 0, released = 0;
    for (const Event& event : s.events()) {
      if (event.time == 0.0) continue;  // it lies on the floor from the start
      touched += event.kind == Event::Kind::touched ? 1 : 0;
      released += event.kind == Event::Kind::released ? 1 : 0;
      CHECK(event.surface == 1);
      if (event.kind == Event::Kind::touched) CHECK((event.impulse - blow).norm() <= 1e-7);
    }
    CHECK(touched == 1);
    CHECK(released == 1);
  }
}

TEST_CASE("where a node falls into a corner each obstacle gets its own part of the impulse") {
  Network net;
  net.add_node(point({0.25, 0, 0.25}, 0.5, {-1, 0, -1.2}));
  for (const Vector3& normal : {Vector3(0, 0, 1), Vector3(1, 0, 0)}) {
    Plane plane;
    plane.friction = frictionless;
    plane.normal = normal;
    net.add_plane(plane);
  }
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    for (const double h : {0.1, 0.004}) {  // in one step, and one after another
      CAPTURE(h);
      Simulation s = simulate(net, scheme.integrator, h);
      s.advance_to(0.4);
      CHECK(s.velocity(0).norm() <= 1e-9);
      CHECK((s.surface_impulse(0) - Vector3(0, 0, -0.6)).norm() <= 1e-9);
      CHECK((s.surface_impulse(1) - Vector3(-0.5, 0, 0)).norm() <= 1e-9);
      CHECK((s.contact_impulse(0) - Vector3(0.5, 0, 0.6)).norm() <= 1e-9);
      for (const Event& event : s.events())
        if (event.kind == Event::Kind::touched)
          CHECK((event.impulse + s.surface_impulse(static_cast<std::size_t>(event.surface))).norm() <= 1e-9);
    }
  }
}

TEST_CASE("with verlet a ball bounces between two planes several times in a step") {
  // 1.4 gaps in a step. Nothing is lost, and nothing else acts: exact, and no step ends on a plane.
  constexpr double gap = 0.05, speed = 6.9, from = 0.021, h = 0.01;
  Network net;
  net.add_node(point({0, 0, from}, mass, {0.5, 0, speed}));
  for (const double side : {0.0, 1.0}) {
    Plane plane;
    plane.name = side > 0.0 ? "above" : "below";
    plane.point = {0, 0, side * gap};
    plane.normal = {0, 0, 1.0 - 2.0 * side};
    plane.friction = frictionless;
    plane.restitution = 1.0;
    net.add_plane(plane);
  }
  Simulation s = simulate(net, {"verlet", {}}, h);
  for (int i = 1; i <= 37; ++i) {
    if (!steps_on(s)) break;
    const double unfolded = std::fmod(from + speed * h * i, 2.0 * gap);
    const double z = unfolded > gap ? 2.0 * gap - unfolded : unfolded;
    CHECK(std::abs(s.position(0).z() - z) <= 1e-12);
    CHECK(std::abs(s.velocity(0).z() - (unfolded > gap ? -speed : speed)) <= 1e-12);
    CHECK(std::abs(s.position(0).x() - 0.5 * h * i) <= 1e-12);
  }
  CHECK((s.surface_impulse(0) + s.surface_impulse(1) + s.contact_impulse(0)).norm() <= 1e-12);
}

TEST_CASE("two coincident planes act as one") {
  // A node, and a rod that falls askew or slides.
  for (const int example : {0, 1, 2, 3}) {
    std::vector<Network> nets;
    for (const int planes : {1, 2}) {
      Network& net = nets.emplace_back();
      net.set_gravity({0, 0, -g});
      const double z = example == 3 ? 0.0 : 0.3;
      net.add_node(point({0, 0, z}, 0.5, {2, 0, 0}));
      if (example > 0) {
        net.add_node(point({0, 0.2, z + (example == 2 ? 0.05 : 0.0)}, 0.5, {2, 0, 0}));
        net.add_rigid(0, 1);
      }
      for (int i = 0; i < planes; ++i) {
        Plane plane;
        plane.name = i == 0 ? "one" : "other";
        plane.friction = {Friction::Kind::coulomb, 0.3};
        plane.restitution = example == 3 ? 0.0 : 0.5;
        net.add_plane(plane);
      }
    }
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name << ", example " << example);
      Simulation one = simulate(nets[0], scheme.integrator, 0.005), two = simulate(nets[1], scheme.integrator, 0.005);
      if (!reaches(one, 0.4) || !reaches(two, 0.4)) continue;
      // The reference puts its steps elsewhere.
      const double allowed = scheme.order > 0.0 ? 1e-10 : 1e-6;
      CHECK(distance(one, two) <= allowed);
      CHECK((one.velocity(0) - two.velocity(0)).norm() <= 10.0 * allowed);
      CHECK((one.contact_impulse(0) - two.contact_impulse(0)).norm() <= allowed);
      CHECK((one.surface_impulse(0) - two.surface_impulse(0) - two.surface_impulse(1)).norm() <= 2.0 * allowed);
    }
  }
}
