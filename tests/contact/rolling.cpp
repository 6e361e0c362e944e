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

double accuracy_of(const Way& way, double h, double first, double second) {
  return way.order == 1.0 ? first * h : way.order == 2.0 ? second * h * h : 1e-6;
}

}  // namespace

TEST_CASE("a rod whose foot slides without friction falls with its centre straight down") {
  constexpr double angle = 0.3, until = 0.45, h = 0.001;
  const Network net = leaning(angle, frictionless);
  const Rod end = advance({angle, 0, 0, 0}, 0.0, until, [](const Rod& rod) { return sliding(rod, 0.0, 1.0); });
  REQUIRE(end[0] < 1.3);
  for (const Way& way : all_ways(1e-10)) {
    INFO(way.name);
    Simulation s = simulate(net, way.integrator, h);
    while (s.time() < until - 0.5 * h) {
      s.step();
      CHECK(s.reaction(0).z() >= -1e-9);
    }
    check_rod(s, end, accuracy_of(way, h, 3.0, 20.0));
    const Vector3 centre = (lower * s.position(0) + upper * s.position(1)) / (lower + upper);
    CHECK(std::abs(centre.dot(aside) - upper / (lower + upper) * length * std::sin(angle)) <= 1e-8);
    CHECK(worst_length(net, s) <= 1e-8);
  }
}
