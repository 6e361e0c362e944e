// Contact scenes with closed forms, or that the tests' own reference solves.
#pragma once

#include <cmath>
#include <numbers>

#include "nets.hpp"

namespace springnet::testing {

// A node that slides off a fixed sphere of radius 1 m from rest, under 1 m/s^2.
inline Network on_sphere() {
  Network net;
  net.add_node(point({0.1, 0, 0.99498743710662}, 2.0));
  net.set_gravity({0, 0, -1});
  Instrument sphere;
  sphere.friction = frictionless;
  net.add_instrument(sphere);
  return net;
}
// z = 2/3 of the start's: there v^2 = 2 g (z0 - z) takes all of gravity's part along the normal.
inline Vector3 sphere_release() {
  const double z = 0.99498743710662 * 2.0 / 3.0;
  return {std::sqrt(1.0 - z * z), 0, z};
}
// The time to slide from `from` to `to` (rad from the top): the integral of d theta / sqrt(2 (cos from - cos theta)),
// with theta = from + s^2, by Simpson's rule. s
inline double time_on_sphere(double from, double to) {
  constexpr int n = 2000;
  const double h = std::sqrt(to - from) / n;
  const auto f = [&](int i) {
    const double s2 = h * i * h * i;
    const double ratio = s2 > 0.0 ? std::sin(0.5 * s2) / s2 : 0.5;
    return 1.0 / std::sqrt(std::sin(from + 0.5 * s2) * ratio);
  };
  double sum = f(0) + f(n);
  for (int i = 1; i < n; ++i) sum += (i % 2 == 1 ? 4.0 : 2.0) * f(i);
  return sum * h / 3.0;
}
inline double sphere_release_time() { return time_on_sphere(std::asin(0.1), std::acos(sphere_release().z())); }

// A node thrown at a sphere of radius 1 m: it lands, slides on, leaves.
inline Network thrown_on_sphere(const Friction& friction) {
  Network net;
  net.add_node(point({-0.1, 0.1, 1.2}, 0.5, {0.8, 0.1, -0.2}));
  net.set_gravity({0, 0, -4});
  Instrument sphere;
  sphere.friction = friction;
  net.add_instrument(sphere);
  return net;
}

// The same on a capsule that lies askew: from its side over the end.
inline Network thrown_on_capsule(const Friction& friction) {
  Network net;
  net.add_node(point({-0.3, 0.05, 0.75}, 0.5, {0.9, 0.1, -0.2}));
  net.set_gravity({0, 0, -4});
  Instrument capsule;
  capsule.first = {-1, 0, 0.2};
  capsule.second = {0, 0.1, 0.1};
  capsule.radius = 0.4;
  capsule.friction = friction;
  net.add_instrument(capsule);
  return net;
}

// Two nodes on a spring, one thrown up, on a floor with friction.
inline Network thrown_pair() {
  Network net;
  net.add_node(point({0, 0, 0}, 0.3));
  net.add_node(point({0.3, 0.2, 0.8}, 0.5, {0.5, -0.3, 2.5}));
  net.add_spring(0, 1, net.add_material(damped(30.0, 0.0)));
  net.set_gravity({0, 0, -4});
  Plane plane;
  plane.friction = {Friction::Kind::coulomb, 0.3};
  net.add_plane(plane);
  return net;
}

// A box of eight nodes that is thrown on a floor with friction.
inline Network thrown_box() {
  Network net;
  Lattice lattice;
  lattice.spacing = Vector3::Constant(0.5);
  lattice.origin = {0, 0, 0.1};
  lattice.diagonals = Diagonals::all;
  net.add_lattice("box", lattice, point(Vector3::Zero(), 0.2, {1.2, 0.4, -0.5}), net.add_material(damped(80.0, 0.4)));
  net.set_gravity({0, 0, -4});
  Plane plane;
  plane.friction = {Friction::Kind::coulomb, 0.3};
  net.add_plane(plane);
  return net;
}

// A node that starts at rest on a plane that is shaken along itself, x = A (cos w t - 1).
inline constexpr double shaken_amplitude = 0.1, shaken_angular_frequency = 2.0 * std::numbers::pi * 0.8,
                        shaken_friction = 0.15;
inline constexpr double shaken_until = 0.9;  // s
inline Network on_shaken_plane() {
  Network net;
  net.add_node(point({0, 0, 0}, 2.0));
  net.set_gravity({0, 0, -1});
  Plane plane;
  plane.friction = {Friction::Kind::coulomb, shaken_friction};
  plane.motion.emplace();
  plane.motion->amplitude = {shaken_amplitude, 0, 0};
  plane.motion->frequency = 0.8;
  plane.motion->phase = 0.5 * std::numbers::pi;
  net.add_plane(plane);
  return net;
}
// It slides with v = -mu g t until the plane is as fast, A w sin w t = mu g t, by bisection. Its slip turns round
// there: the plane is too fast to hold it. s
inline double shaken_stick_time() {
  double below = 2.5 / shaken_angular_frequency, above = 3.1 / shaken_angular_frequency;
  for (int i = 0; i < 100; ++i) {
    const double t = 0.5 * (below + above);
    (shaken_amplitude * shaken_angular_frequency * std::sin(shaken_angular_frequency * t) > shaken_friction * t
         ? below
         : above) = t;
  }
  return below;
}
// Where it is at shaken_until, m.
inline double shaken_end() {
  const double t = shaken_stick_time(), later = shaken_until - t;
  return shaken_friction * (-0.5 * t * t - t * later + 0.5 * later * later);
}

// A node between springs on a plane that is shaken along itself, slowly enough to hold it for a part of each period.
inline Network shaken_oscillator() {
  Network net;
  Node wall = point({-1, 0, 0});
  wall.fixed = true;
  net.add_node(wall);
  net.add_node(point({0, 0, 0}, 0.5));
  net.add_spring(0, 1, net.add_material(damped(15.0, 0.0)));
  net.set_gravity({0, 0, -5});
  Plane plane;
  plane.friction = {Friction::Kind::coulomb, 0.3};
  plane.motion.emplace();
  plane.motion->amplitude = {0.07, 0.02, 0};
  plane.motion->frequency = 0.7;
  net.add_plane(plane);
  return net;
}

// A force that grows along a plane until friction no longer holds: F = r t.
inline constexpr double ramp_mass = 0.8, ramp_friction = 0.4, ramp_gravity = 5.0, ramp_rate = 2.0;  // kg, 1, m/s^2, N/s
inline constexpr double ramp_slip_time = ramp_friction * ramp_mass * ramp_gravity / ramp_rate;      // s
inline Network on_ramp(const Vector3& direction = Vector3::UnitX()) {
  Network net;
  net.add_node(point({0, 0, 0}, ramp_mass));
  net.set_gravity({0, 0, -ramp_gravity});
  Load load;
  load.nodes = {0};
  load.from = 0.0;
  load.course.ramp = 10.0;
  load.force = ramp_rate * load.course.ramp * direction;
  net.add_load(load);
  Plane plane;
  plane.friction = {Friction::Kind::coulomb, ramp_friction};
  net.add_plane(plane);
  return net;
}

}  // namespace springnet::testing
