// Boxes as obstacles: faces, rounded edges and corners.

#include <doctest/doctest.h>

#include <cmath>

#include <Eigen/Geometry>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double mass = 0.6;        // kg
const Vector3 size(1.2, 0.8, 0.6);  // m

Network with_box(const Eigen::Matrix3d& axes, double radius, const Node& node, double gravity) {
  Network net;
  net.add_node(node);
  net.set_gravity({0, 0, -gravity});
  Instrument box;
  box.friction = frictionless;
  box.box.emplace();
  box.box->size = size;
  box.box->axes = axes;
  box.box->radius = radius;
  net.add_instrument(box);
  return net;
}

std::size_t releases(const Simulation& s) {
  std::size_t released = 0;
  for (const Event& event : s.events()) released += event.kind == Event::Kind::released ? 1 : 0;
  return released;
}

}  // namespace

TEST_CASE("a node slides down the face of a box and flies off at its edge") {
  // From the middle of the upper face of a box that is tilted, turned about z, with sharp edges or rounded ones. The
  // face ends where the rounding begins, which bends faster than gravity.
  constexpr double g = 9.81, tilt = 0.35;
  const Eigen::Matrix3d axes =
      (Eigen::AngleAxisd(0.8, Vector3::UnitZ()) * Eigen::AngleAxisd(tilt, Vector3::UnitY())).toRotationMatrix();
  for (const double radius : {0.0, 0.02}) {
    const Vector3 start = 0.5 * size.z() * axes.col(2);
    const double far = 0.5 * size.x() - radius, a = g * std::sin(tilt), leaves = std::sqrt(2.0 * far / a), later = 0.1;
    const double speed = a * leaves;
    if (radius > 0.0) REQUIRE(speed * speed / radius > g);
    const Vector3 end = start + (far + later * speed) * axes.col(0) - Vector3(0, 0, 0.5 * g * later * later);
    const Network net = with_box(axes, radius, point(start, mass), g);
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name << ", rounded by " << radius);
      const double h = 0.002;
      Simulation s = simulate(net, scheme.integrator, h);
      if (!reaches(s, 0.9 * leaves)) continue;
      CHECK(s.touching(0));
      CHECK(std::abs(axes.col(2).dot(s.reaction(0)) - mass * g * std::cos(tilt)) <= 1e-6);
      if (!reaches(s, leaves + later)) continue;
      // Where the face ends the reaction jumps from m g cos(tilt) to zero, within a step: up to that less, or more, for
      // h, and on with it.
      const double jump = h * g * std::cos(tilt) * later;
      // generalized_alpha locates a sharp edge; a rounded one bends within the step that ends there.
      const bool located = scheme.order == 0.0 || (scheme.name == "generalized_alpha" && radius == 0.0);
      CHECK((s.position(0) - end).norm() <= (scheme.order == 1.0 ? 3.0 * h : located ? 1e-6 : jump));
      CHECK(releases(s) == 1);
      CHECK_FALSE(s.touching(0));
    }
  }
}

TEST_CASE("rounded edges and corners of a box are as round as they say") {
  // From 0.1 rad off the top of an edge's cylinder or a corner's sphere: it leaves at cos = 2/3 of the start's.
  constexpr double radius = 0.25, from = 0.1, g = 1.0, h = 0.002;
  const double to = std::acos(2.0 / 3.0 * std::cos(from)), scale = std::sqrt(radius / g);
  const double leaves = scale * time_on_sphere(from, to), later = 0.1, speed = std::sqrt(g * radius * std::cos(to));
  for (const bool corner : {false, true}) {
    const Vector3 out = corner ? Vector3(0.6, -0.8, 0) : Vector3(1, 0, 0);
    const Vector3 centre(0.5 * size.x() - radius, corner ? radius - 0.5 * size.y() : 0.1, 0.5 * size.z() - radius);
    const auto at = [&](double angle) -> Vector3 { return std::sin(angle) * out + std::cos(angle) * Vector3::UnitZ(); };
    const Vector3 end = centre + radius * at(to) +
                        later * speed * (std::cos(to) * out - std::sin(to) * Vector3::UnitZ()) -
                        Vector3(0, 0, 0.5 * g * later * later);
    const Network net = with_box(Eigen::Matrix3d::Identity(), radius, point(centre + radius * at(from), mass), g);
    for (const Scheme& scheme : all_schemes(1e-10)) {
      INFO(scheme.name << (corner ? ", corner" : ", edge"));
      Simulation s = simulate(net, scheme.integrator, h);
      if (!reaches(s, leaves + later)) continue;
      CHECK((s.position(0) - end).norm() <= (scheme.order == 1.0   ? 3.0 * h
                                             : scheme.order == 2.0 ? 20.0 * h * h
                                                                   : 1e-6));
      CHECK(releases(s) == 1);
    }
  }
}

TEST_CASE("a node thrown at a box stops at the face that it meets") {
  const Eigen::Matrix3d axes = Eigen::AngleAxisd(0.6, Vector3(1, 1, 0.3).normalized()).toRotationMatrix();
  for (int c = 0; c < 3; ++c) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3 normal = side * axes.col(c);
      const Vector3 meets = 0.5 * size[c] * normal + 0.1 * axes.col((c + 1) % 3) - 0.15 * axes.col((c + 2) % 3);
      const Vector3 along = 0.1 * axes.col((c + 1) % 3);
      const Vector3 velocity = -1.5 * normal + along;
      const Network net = with_box(axes, 0.0, point(meets - 0.3 * velocity, mass, velocity), 0.0);
      for (const Scheme& scheme : all_schemes(1e-10)) {
        INFO(scheme.name << ", face " << side * (c + 1));
        Simulation s = simulate(net, scheme.integrator, 0.004);
        if (!reaches(s, 0.7)) continue;
        CHECK((s.position(0) - meets - 0.4 * along).norm() <= (scheme.order > 0.0 ? 1e-8 : 1e-6));
        CHECK((s.contact_impulse(0) - 1.5 * mass * normal).norm() <= (scheme.order > 0.0 ? 1e-8 : 1e-6));
        CHECK((s.velocity(0) - along).norm() <= 1e-8);
      }
    }
  }
}
