// Rays against faces, planes and instruments.

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// One node far away, and these obstacles.
Simulation surroundings(const std::vector<Plane>& planes, const std::vector<Instrument>& instruments) {
  Network net;
  net.add_node(point({1000, 1000, 1000}));
  for (const Plane& each : planes) net.add_plane(each);
  for (const Instrument& each : instruments) net.add_instrument(each);
  return simulate(net, recurrent(newton, 1e-10), 0.1);
}

Instrument rounded_box() {
  Instrument box;
  box.name = "box";
  box.first = {0.3, -0.2, 0.5};
  box.box = BoxShape{{1.0, 2.0, 0.6}, Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix(), 0.15};
  return box;
}

// Signed distance of a point from a capsule or a rounded box, by its definition.
double distance_to(const Instrument& shape, const Vector3& x) {
  if (!shape.box) {
    const Vector3 axis = shape.second - shape.first;
    const double along =
        axis.isZero(0.0) ? 0.0 : std::clamp((x - shape.first).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    return (x - shape.first - along * axis).norm() - shape.radius;
  }
  const double r = shape.box->radius;
  const Vector3 beyond =
      (shape.box->axes.transpose() * (x - shape.first)).cwiseAbs() - 0.5 * shape.box->size + Vector3::Constant(r);
  return std::min(beyond.maxCoeff(), 0.0) + beyond.cwiseMax(0.0).norm() - r;
}

}  // namespace

TEST_CASE("a ray meets planes, spheres, capsules and boxes at distances by hand") {
  Instrument sphere{.name = "ball", .first = {5, 0, 0}, .second = {5, 0, 0}, .radius = 1.0};
  Instrument capsule{.name = "stick", .first = {0, 5, -1}, .second = {0, 5, 1}, .radius = 0.5};
  Instrument box{.name = "box", .first = {0, -5, 0}};
  box.box = BoxShape{{1, 2, 3}};
  const Simulation simulation = surroundings({{"floor", {0, 0, -4}, Vector3::UnitZ()}}, {sphere, capsule, box});
  const auto hit = [&](const Vector3& direction) { return simulation.cast_ray(Vector3::Zero(), direction); };
  REQUIRE(hit({2, 0, 0}));
  CHECK(hit({2, 0, 0})->distance == doctest::Approx(4.0).epsilon(1e-15));
  CHECK(hit({2, 0, 0})->surface == 1);
  CHECK(hit({2, 0, 0})->face == -1);
  CHECK(hit({0, 0.1, 0})->distance == doctest::Approx(4.5).epsilon(1e-15));
  CHECK(hit({0, 0.1, 0})->surface == 2);
  CHECK(hit({0, -1, 0})->distance == doctest::Approx(4.0).epsilon(1e-15));
  CHECK(hit({0, -1, 0})->surface == 3);
  CHECK(hit({0, 0, -1})->distance == doctest::Approx(4.0).epsilon(1e-15));
  CHECK(hit({0, 0, -1})->point == Vector3(0, 0, -4));
  CHECK(hit({0, 0, -1})->surface == 0);
  CHECK(hit({3, 0, -4})->distance == doctest::Approx(5.0).epsilon(1e-15));
  CHECK_FALSE(hit({0, 0, 1}));
  CHECK_FALSE(hit({1, 1, 0}));  // along the floor, between the shapes
  // From within: where it leaves.
  CHECK(simulation.cast_ray({5, 0, 0}, {1, 0, 0})->distance == doctest::Approx(1.0).epsilon(1e-15));
}

TEST_CASE("rays against spheres, capsules and rounded boxes end on the surface, and nothing lies before") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> coordinate(-2.0, 2.0);
  Instrument sphere{.name = "s", .first = {0.1, 0.2, 0.3}, .second = {0.1, 0.2, 0.3}, .radius = 0.7};
  Instrument capsule{.name = "c", .first = {-0.8, 0.2, 0.3}, .second = {0.7, -0.4, 0.1}, .radius = 0.4};
  for (const Instrument& shape : {sphere, capsule, rounded_box()}) {
    CAPTURE(shape.name);
    const Simulation simulation = surroundings({}, {shape});
    int hits = 0;
    for (int k = 0; k < 400; ++k) {
      const Vector3 from(coordinate(random), coordinate(random), coordinate(random));
      const Vector3 to = shape.first + 0.6 * Vector3(coordinate(random), coordinate(random), coordinate(random));
      const Vector3 direction = (to - from).normalized();
      const std::optional<RayHit> hit = simulation.cast_ray(from, direction);
      const double start = distance_to(shape, from);
      const double end = hit ? hit->distance : 8.0;
      if (hit) {
        ++hits;
        CHECK(std::abs(distance_to(shape, hit->point)) < 1e-12);
        CHECK((from + hit->distance * direction - hit->point).norm() < 1e-14);
      }
      // On the way it stays on one side.
      for (int i = 1; i < 64; ++i)
        CHECK(distance_to(shape, from + i / 64.0 * end * direction) * (start > 0.0 ? 1.0 : -1.0) > -1e-12);
    }
    CHECK(hits > 100);
    CHECK(hits < 400);
  }
}

TEST_CASE("rays follow surfaces that move and turn") {
  Instrument box{.name = "box", .first = {0, 0, 0}};
  box.box = BoxShape{{4, 1, 1}};
  box.turn.emplace().rate = std::numbers::pi / 2;
  Motion motion;
  motion.times = {0, 1};
  motion.displacements = {{0, 0, 0}, {0, 0, 3}};
  box.motion = motion;
  Simulation simulation = surroundings({}, {box});
  CHECK(simulation.cast_ray({0, -10, 0}, {0, 1, 0})->distance == doctest::Approx(9.5));
  simulation.advance_to(1.0);
  CHECK_FALSE(simulation.cast_ray({0, -10, 0}, {0, 1, 0}));
  CHECK(simulation.cast_ray({0, -10, 3}, {0, 1, 0})->distance == doctest::Approx(8.0));
}

TEST_CASE("a ray meets the nearest face of a body where it is now, and never slips between faces") {
  Network net;
  Lattice lattice;
  lattice.nodes = {5, 5, 3};
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(3.0, 1.0)));
  net.set_gravity({0, 0, -10});
  Simulation simulation = simulate(net, recurrent(newton, 1e-10), 0.01);
  simulation.advance_to(1.0);
  const double fallen = 2.0 - simulation.position(50).z();
  CHECK(fallen > 4.0);
  // Also along edges and through corners of the faces.
  for (int i = 1; i < 16; ++i)
    for (int j = 1; j < 16; ++j) {
      const double x = 0.25 * i, y = 0.25 * j;
      const std::optional<RayHit> hit = simulation.cast_ray({x, y, 10}, {0, 0, -1});
      REQUIRE(hit);
      CHECK(hit->distance == doctest::Approx(8.0 + fallen).epsilon(1e-9));
      CHECK(hit->surface == -1);
      const Face& face = net.faces()[static_cast<std::size_t>(hit->face)];
      CHECK(std::find(face.begin(), face.end(), hit->node) != face.end());
      for (const NodeIndex corner : face)
        CHECK((simulation.position(corner) - hit->point).norm() >=
              (simulation.position(hit->node) - hit->point).norm());
      CHECK(simulation.cast_ray({x, y, -10}, {0, 0, 1}));
    }
  CHECK_FALSE(simulation.cast_ray({4.01, 2, 10}, {0, 0, -1}));
  // Torn faces are not there: the ray meets the lower side.
  const RayHit top = *simulation.cast_ray({2.3, 2.2, 10}, {0, 0, -1});
  const Face& face = net.faces()[static_cast<std::size_t>(top.face)];
  for (SpringIndex s = 0; s < net.springs().size(); ++s)
    if (std::count(face.begin(), face.end(), net.springs()[s].first) +
            std::count(face.begin(), face.end(), net.springs()[s].second) ==
        2)
      simulation.cut({s});
  CHECK(simulation.cast_ray({2.3, 2.2, 10}, {0, 0, -1})->distance == doctest::Approx(top.distance + 2.0).epsilon(1e-9));
}

TEST_CASE("faces of triangles that have no springs are torn with them") {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(1, 1, 0)})
    net.add_node(point(p));
  const MaterialIndex material = net.add_material(damped(1.0, 0.0));
  net.add_element(Invariant::area, {0, 1, 2}, material);
  net.add_element(Invariant::area, {1, 3, 2}, material);
  net.add_face({0, 1, 2});
  net.add_face({1, 3, 2});
  Simulation simulation = simulate(net, recurrent(newton, 1e-10), 0.01);
  CHECK(simulation.cast_ray({0.2, 0.2, 1}, {0, 0, -1})->face == 0);
  CHECK(simulation.cast_ray({0.8, 0.8, 1}, {0, 0, -1})->face == 1);
  CHECK(simulation.cast_ray({0.8, 0.8, 1}, {0, 0, -1})->node == 3);
  simulation.cut_polygon({{0.5, -1, -1}, {0.5, 0.1, -1}, {0.5, 0.1, 1}, {0.5, -1, 1}});
  CHECK_FALSE(simulation.element_alive(0));
  CHECK_FALSE(simulation.cast_ray({0.2, 0.2, 1}, {0, 0, -1}));
  CHECK(simulation.cast_ray({0.8, 0.8, 1}, {0, 0, -1})->face == 1);
}
