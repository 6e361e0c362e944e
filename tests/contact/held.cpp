// Surfaces whose velocity jumps: a jump in the separating direction is the limit of a steep motion, and contact breaks.

#include <doctest/doctest.h>

#include <cmath>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double g = 4.0, speed = 1.0, starting = 0.1, stops = 0.35;              // m/s^2, m/s, s
constexpr double height = speed * (stops - 0.5 * starting);                       // m
const double top = height + 0.5 * speed * speed / g, at_top = stops + speed / g;  // m, s

// A node that lies on a plane, which rises at 1 m/s, after a smooth start or at once, and stops abruptly, or evenly
// within `during`, half of it before the time and half after.
Network stopping(const Friction& friction, double during) {
  Network net;
  net.add_node(point({0, 0, 0}, 0.4));
  net.set_gravity({0, 0, -g});
  Plane plane;
  plane.friction = friction;
  plane.motion.emplace();
  Motion& motion = *plane.motion;
  if (during == 0.0) {
    motion.interpolation = Motion::Interpolation::linear;
    motion.times = {0.5 * starting, stops, 2.0};
    motion.displacements = {Vector3::Zero(), {0, 0, height}, {0, 0, height}};
  } else {
    for (int i = 0; i < 8; ++i) motion.times.push_back(i * starting / 8.0);
    for (const double t : {0.1, 0.2, 0.3}) motion.times.push_back(t);
    for (int i = -8; i <= 8; ++i) motion.times.push_back(stops + i * during / 8.0);
    for (const double t : {1.0, 2.0}) motion.times.push_back(t);
    for (const double t : motion.times) {
      const double early = std::max(0.0, starting - t), late = std::clamp(t - stops + 0.5 * during, 0.0, during);
      const double steady = std::min(t, stops - 0.5 * during) - 0.5 * starting;
      const double z = steady + early * early / (2.0 * starting) + late - late * late / (2.0 * during);
      motion.displacements.emplace_back(0, 0, t > 0.0 ? speed * z : 0.0);
    }
  }
  net.add_plane(plane);
  return net;
}

double highest(const Network& net, const LawUse& integrator, double h, std::size_t& released) {
  Simulation s = simulate(net, integrator, h);
  double highest = 0.0;
  while (s.time() < at_top + 0.05) {
    s.step();
    highest = std::max(highest, s.position(0).z());
  }
  released = 0;
  for (const Event& event : s.events()) released += event.kind == Event::Kind::released ? 1 : 0;
  return highest;
}

}  // namespace

TEST_CASE("a plane that rises and stops throws the node on it, held or not, at once or within a millisecond") {
  REQUIRE(top == doctest::Approx(0.425));
  const Friction kinds[] = {frictionless, {Friction::Kind::coulomb, 0.5}, {Friction::Kind::held, 0.0}};
  for (const Friction& friction : kinds) {
    for (const double during : {0.0, 1e-3}) {
      for (const Scheme& scheme : all_schemes(1e-10)) {
        INFO(scheme.name << ", friction (0: held, 1: none) " << static_cast<int>(friction.kind) << ", stops within "
                         << during);
        std::size_t released = 0;
        const double h = 0.002;
        const double reached = highest(stopping(friction, during), scheme.integrator, h, released);
        // The stop may fall within a step; in the flight first order loses g t h / 2.
        CHECK(std::abs(reached - top) <= (scheme.order > 0.0 ? 1.6 * h * speed : 2e-5) + 3.0 * during * speed);
        // The table's cubics hop by a hundredth of the speed where it begins to fall.
        CHECK(released >= 1);
        if (during == 0.0) CHECK(released == 1);
      }
    }
  }
}

TEST_CASE("a plane whose velocity jumps along itself keeps the node that it holds") {
  // And where it turns towards the node: the node goes with it, after an impulse.
  Network net;
  net.add_node(point({0, 0, 0}, 0.4));
  net.set_gravity({0, 0, -g});
  Plane plane;
  plane.motion.emplace();
  plane.motion->interpolation = Motion::Interpolation::linear;
  plane.motion->times = {0.0, 0.2, 0.4, 0.6};
  plane.motion->displacements = {Vector3::Zero(), {0.1, 0, 0}, {0, 0.1, 0.05}, {0, 0.1, 0.35}};
  net.add_plane(plane);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, 0.004);
    s.advance_to(0.58);
    CHECK(s.held(0));
    CHECK((s.position(0) - Vector3(0, 0.1, 0.05 + 0.27)).norm() <= 1e-9);
    // From 0 to 0.25 m/s, then to 1.5 m/s upwards; in the network that is a reaction over a step.
    if (scheme.order == 0.0) CHECK(std::abs(s.contact_impulse(0).z() - 0.4 * 1.5) <= 1e-6);
  }
}
