// The tests' own reference against closed forms.

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "nets.hpp"
#include "reference.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double g = 9.81;

using ContactChange = Reference::Change;
using Mode = Reference::Mode;

}  // namespace

TEST_CASE("the reference leaves a sphere where the closed form says") {
  Reference reference(on_sphere());
  reference.advance_to(2.9);
  const Vector3 place = sphere_release();
  const double release_time = sphere_release_time();
  CHECK(release_time == doctest::Approx(2.83949).epsilon(1e-6));
  CHECK(std::abs(reference.time_of(ContactChange::released) - release_time) <= 1e-10);
  const double later = 2.9 - release_time, speed = std::sqrt(place.z());
  const Vector3 velocity(speed * place.z(), 0, -speed * place.x());
  const Vector3 truth = place + later * velocity - Vector3(0, 0, 0.5 * later * later);
  CHECK((reference.position(0) - truth).norm() <= 1e-10);
  CHECK(reference.events().size() == 2);
}

TEST_CASE("the reference finds how a puck on an incline turns and comes to rest") {
  // Across the slope at first. With k = mu / tan(angle) > 1 and the angle phi between velocity and slope,
  // v sin(phi) / tan^k(phi / 2) stays, and the puck rests after v k / (g sin(angle) (k^2 - 1)).
  constexpr double angle = 0.4, speed = 1.5, k = 1.6;
  Network net;
  net.add_node(point(Vector3::Zero(), 0.7, {0, speed, 0}));
  net.set_gravity({g * std::sin(angle), 0, -g * std::cos(angle)});
  Plane plane;
  plane.friction = {Friction::Kind::coulomb, k * std::tan(angle)};
  net.add_plane(plane);
  Reference reference(net);
  const double rest_time = speed * k / (g * std::sin(angle) * (k * k - 1.0));
  reference.advance_to(0.5 * rest_time);
  const Vector3 v = reference.velocity(0);
  const double phi = std::atan2(v.y(), v.x());
  CHECK(v.norm() * std::sin(phi) / std::pow(std::tan(0.5 * phi), k) == doctest::Approx(speed).epsilon(1e-11));
  reference.advance_to(2.0 * rest_time);
  CHECK(std::abs(reference.time_of(ContactChange::stuck) - rest_time) <= 1e-11);
  CHECK(reference.mode(0) == Mode::sticking);
}

TEST_CASE("the reference slips where a ramp of force reaches the cone, and sticks again") {
  // F = r t along the plane: slips at mu N / r, then x = r (t - t1)^3 / (6 m).
  Reference reference(on_ramp());
  reference.advance_to(ramp_slip_time + 0.5);
  CHECK(std::abs(reference.time_of(ContactChange::slipped) - ramp_slip_time) <= 1e-13);
  CHECK(std::abs(reference.position(0).x() - ramp_rate / ramp_mass * 0.125 / 6.0) <= 1e-12);
}

TEST_CASE("the reference sticks on a shaken plane at the closed form's time") {
  Reference reference(on_shaken_plane());
  reference.advance_to(shaken_until);
  CHECK(std::abs(reference.time_of(ContactChange::stuck) - shaken_stick_time()) <= 1e-11);
}

TEST_CASE("the reference's impulses and reactions make up its momentum") {
  const Network net = thrown_on_sphere({Friction::Kind::coulomb, 0.2});
  Reference reference(net);
  reference.advance_to(1.2);
  CHECK(reference.events().size() >= 2);
  const Vector3 gained = net.nodes()[0].mass * (reference.velocity(0) - net.nodes()[0].velocity);
  const Vector3 given =
      1.2 * net.nodes()[0].mass * net.gravity() + reference.reaction_integral(0) + reference.impulse(0);
  CHECK((gained - given).norm() <= 1e-11);
}
