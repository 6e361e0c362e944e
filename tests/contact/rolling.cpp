// Rigid bodies that fall, slide and roll on a plane, against the motion of one rigid body.

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include <Eigen/Geometry>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double g = 9.81, length = 0.8, lower = 0.6, upper = 0.9;  // m/s^2, m, kg, kg
const Vector3 aside(0.6, 0.8, 0.0);                                 // where rods fall to

// Angle from the vertical, its rate; place of the foot along `aside`, its rate. rad, rad/s, m, m/s
using Rod = std::array<double, 4>;

// Runge and Kutta's method of fourth order, with steps that leave 1e-12.
Rod advance(Rod rod, double from, double to, const std::function<std::array<double, 2>(const Rod&)>& accelerations) {
  const int steps = 1 + static_cast<int>(std::ceil((to - from) * 20000.0));
  const double h = (to - from) / steps;
  const auto rate = [&](const Rod& y) -> Rod {
    const auto a = accelerations(y);
    return {y[1], a[0], y[3], a[1]};
  };
  const auto moved = [](const Rod& y, double by, const Rod& k) -> Rod {
    return {y[0] + by * k[0], y[1] + by * k[1], y[2] + by * k[2], y[3] + by * k[3]};
  };
  for (int i = 0; i < steps; ++i) {
    const Rod k1 = rate(rod), k2 = rate(moved(rod, h / 2, k1)), k3 = rate(moved(rod, h / 2, k2)),
              k4 = rate(moved(rod, h, k3));
    rod = moved(moved(moved(moved(rod, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
  }
  return rod;
}

// Force along the rod, > 0 pushes the foot down; the foot's acceleration is `a`. N
double push_of(const Rod& rod, double a) {
  return upper * (a * std::sin(rod[0]) - length * rod[1] * rod[1] + g * std::cos(rod[0]));
}
// The foot slides with friction mu against its slip, whose sign is `slip`.
std::array<double, 2> sliding(const Rod& rod, double mu, double slip) {
  const double s = std::sin(rod[0]), c = std::cos(rod[0]), edge = s + slip * mu * c;
  const double a = (-edge * push_of(rod, 0.0) - slip * mu * lower * g) / (lower + upper * s * edge);
  return {(g * s - a * c) / length, a};
}

std::array<double, 2> sticking(const Rod& rod) { return {g / length * std::sin(rod[0]), 0.0}; }

Network leaning(double angle, const Friction& friction) {
  Network net;
  net.add_node(point({0, 0, 0}, lower));
  net.add_node(point(length * (std::sin(angle) * aside + std::cos(angle) * Vector3::UnitZ()), upper));
  net.add_rigid(0, 1);
  net.set_gravity({0, 0, -g});
  Plane plane;
  plane.friction = friction;
  net.add_plane(plane);
  return net;
}

void check_rod(const Simulation& s, const Rod& rod, double accuracy) {
  const Vector3 foot = rod[2] * aside;
  const Vector3 tip = foot + length * (std::sin(rod[0]) * aside + std::cos(rod[0]) * Vector3::UnitZ());
  CHECK((s.position(0) - foot).norm() <= accuracy);
  CHECK((s.position(1) - tip).norm() <= accuracy);
}

double accuracy_of(const Scheme& scheme, double h, double first, double second) {
  return scheme.order == 1.0 ? first * h : scheme.order == 2.0 ? second * h * h : 1e-6;
}

}  // namespace

TEST_CASE("a rod whose foot slides without friction falls with its centre straight down") {
  constexpr double angle = 0.3, until = 0.45, h = 0.001;
  const Network net = leaning(angle, frictionless);
  const Rod end = advance({angle, 0, 0, 0}, 0.0, until, [](const Rod& rod) { return sliding(rod, 0.0, 1.0); });
  REQUIRE(end[0] < 1.3);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(net, scheme.integrator, h);
    while (s.time() < until - 0.5 * h) {
      s.step();
      CHECK(s.reaction(0).z() >= -1e-9);
    }
    check_rod(s, end, accuracy_of(scheme, h, 3.0, 20.0));
    const Vector3 centre = (lower * s.position(0) + upper * s.position(1)) / (lower + upper);
    CHECK(std::abs(centre.dot(aside) - upper / (lower + upper) * length * std::sin(angle)) <= 1e-8);
    CHECK(worst_length(net, s) <= 1e-8);
  }
}

TEST_CASE("a hexagon rolls over its corners: each touch takes a quarter of its spin") {
  // All mass in the corners, R from the centre: about a corner that sticks 2 M R^2 phi'' = M g R sin(phi), and where
  // the next one touches, angular momentum about that one stays: spin times (1 + cos 60 deg) / 2.
  constexpr double radius = 0.5, half = std::numbers::pi / 6.0, spin = 3.5, mu = 3.0;
  Network net;
  Rod wheel{0.9 * half, spin, 0, 0};
  const Vector3 centre(radius * std::sin(wheel[0]), 0, radius * std::cos(wheel[0]));
  for (int i = 0; i < 6; ++i) {
    // Corner 0 is the one that touches; the next one on the way is 1.
    const double angle = std::numbers::pi + wheel[0] - 2.0 * half * i;
    const Vector3 place = centre + radius * Vector3(std::sin(angle), 0, std::cos(angle));
    net.add_node(
        point(i == 0 ? Vector3::Zero() : place, 0.5, spin * Vector3::UnitY().cross(i == 0 ? Vector3::Zero() : place)));
  }
  for (NodeIndex i = 0; i < 6; ++i) net.add_rigid(i, (i + 1) % 6);
  for (const auto& [a, b] : {std::array<NodeIndex, 2>{0, 2}, {2, 4}, {4, 0}}) net.add_rigid(a, b);
  net.set_gravity({0, 0, -g});
  Plane plane;
  plane.friction = {Friction::Kind::coulomb, mu};
  net.add_plane(plane);
  const auto falls = [](const Rod& rod) -> std::array<double, 2> {
    return {g / (2.0 * radius) * std::sin(rod[0]), 0.0};
  };
  // Two touches and on.
  double time = 0.0, corner = 0.0;
  std::array<double, 2> touches{};
  for (double& touch : touches) {
    double below = time, above = time + 1.0;
    for (int i = 0; i < 45; ++i) {
      const double middle = 0.5 * (below + above);
      (advance(wheel, time, middle, falls)[0] < half ? below : above) = middle;
    }
    touch = below;
    wheel = advance(wheel, time, touch, falls);
    wheel = {-half, 0.75 * wheel[1], 0, 0};
    time = touch;
    corner += radius;
  }
  const double until = time + 0.05;
  wheel = advance(wheel, time, until, falls);
  const Vector3 end(corner + radius * std::sin(wheel[0]), 0, radius * std::cos(wheel[0]));
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    constexpr double h = 0.0005;
    Simulation s = simulate(net, scheme.integrator, scheme.order > 0.0 ? h : 0.01);
    if (!reaches(s, until)) continue;
    Vector3 middle = Vector3::Zero();
    for (NodeIndex k = 0; k < 6; ++k) middle += s.position(k) / 6.0;
    // A touch falls within a step, of the spin times the radius.
    CHECK((middle - end).norm() <= (scheme.order > 0.0 ? 4.0 * h : 1e-6));
    CHECK(worst_length(net, s) <= 1e-8);
    std::vector<double> touched;
    for (const Event& event : s.events())
      if (event.kind == Event::Kind::touched && event.time > 0.0) touched.push_back(event.time);
    CHECK(touched.size() == 2);
    if (touched.size() != 2) continue;
    for (const std::size_t i : {0u, 1u})
      CHECK(std::abs(touched[i] - touches[i]) <= (scheme.order > 0.0 ? 3.0 * h : 1e-6));
  }
}

TEST_CASE("a rod's foot sticks until its push leaves the cone, and slips back with friction") {
  constexpr double angle = 0.3, mu = 0.23, h = 0.0005;
  // The time of slip, by bisection: T = C sin, N = m0 g + C cos.
  const auto margin = [](const Rod& rod) {
    const double push = push_of(rod, 0.0);
    return mu * (lower * g + push * std::cos(rod[0])) - push * std::sin(rod[0]);
  };
  double below = 0.0, above = 0.35;
  REQUIRE(margin({angle, 0, 0, 0}) > 0.0);
  REQUIRE(margin(advance({angle, 0, 0, 0}, 0.0, above, sticking)) < 0.0);
  for (int i = 0; i < 45; ++i) {
    const double middle = 0.5 * (below + above);
    (margin(advance({angle, 0, 0, 0}, 0.0, middle, sticking)) > 0.0 ? below : above) = middle;
  }
  const double slips = below, until = slips + 0.1;
  const Rod at_slip = advance({angle, 0, 0, 0}, 0.0, slips, sticking);
  const Rod end = advance(at_slip, slips, until, [](const Rod& rod) { return sliding(rod, mu, -1.0); });
  REQUIRE(end[3] < -1e-3);
  for (const Scheme& scheme : all_schemes(1e-10)) {
    INFO(scheme.name);
    Simulation s = simulate(leaning(angle, {Friction::Kind::coulomb, mu}), scheme.integrator, h);
    if (!reaches(s, until)) continue;
    check_rod(s, end, accuracy_of(scheme, h, 3.0, 60.0));
    double slipped = 0.0;
    for (const Event& event : s.events())
      if (event.kind == Event::Kind::slipped && slipped == 0.0) slipped = event.time;
    CHECK(std::abs(slipped - slips) <= (scheme.order == 1.0 ? 3.0 * h : scheme.order == 2.0 ? 1.5 * h : 1e-6));
  }
}
