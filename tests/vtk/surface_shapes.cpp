#include "vtk/surface_shapes.hpp"
#include "constraints/obstacle.hpp"

#include <algorithm>
#include <map>
#include <numbers>
#include <utility>

#include <doctest/doctest.h>
#include <Eigen/Geometry>

using namespace springnet;

namespace {

// Of a closed surface with its triangles turned outward.
double enclosed_volume(const SurfaceShapes& shapes) {
  double volume = 0.0;
  for (const Face& t : shapes.triangles) {
    volume += shapes.points[t[0]].dot(shapes.points[t[1]].cross(shapes.points[t[2]])) / 6.0;
  }
  return volume;
}

// Every edge belongs to two triangles, once in each direction.
bool is_closed(const SurfaceShapes& shapes) {
  std::map<std::pair<NodeIndex, NodeIndex>, int> edges;
  for (const Face& t : shapes.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (count != 1 || back == edges.end()) return false;
  }
  return true;
}

SurfaceShapes round_shape(const Vector3& first, const Vector3& second, double radius) {
  Network network;
  network.add_instrument({"", first, second, radius, {}, std::nullopt});
  return shapes_of(network);
}

}  // namespace

TEST_CASE("a sphere and a capsule are closed, have their radius everywhere and nearly their volume") {
  const Vector3 first(1.0, -2.0, 0.5), second(1.5, -1.0, 3.0);
  constexpr double radius = 0.4;
  const double ball = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
  const double tube = std::numbers::pi * radius * radius * (second - first).norm();
  for (const bool capsule : {false, true}) {
    CAPTURE(capsule);
    const SurfaceShapes shapes = round_shape(first, capsule ? second : first, radius);
    CHECK(is_closed(shapes));
    for (const Vector3& point : shapes.points) {
      const Vector3 axis = capsule ? Vector3(second - first) : Vector3::UnitX();
      const double along = capsule ? std::clamp((point - first).dot(axis) / axis.squaredNorm(), 0.0, 1.0) : 0.0;
      CHECK((point - first - along * axis).norm() == doctest::Approx(radius).epsilon(1e-12));
    }
    // Chords of 15 degrees: 1 - sinc(15 degrees) is 1.1 % around, as much again along.
    const double volume = enclosed_volume(shapes), expected = ball + (capsule ? tube : 0.0);
    CHECK(volume < expected);
    CHECK(volume > 0.97 * expected);
  }
}

TEST_CASE("a box is closed, lies on its surface, and has its volume, exactly if it has sharp edges") {
  Instrument instrument;
  instrument.first = Vector3(1.0, -2.0, 0.5);
  instrument.box.emplace();
  instrument.box->size = {1.0, 0.5, 0.8};
  instrument.box->axes = Eigen::AngleAxisd(0.6, Vector3(0.6, 0.0, 0.8)).toRotationMatrix();
  for (const double radius : {0.0, 0.1, 0.25}) {
    CAPTURE(radius);
    instrument.box->radius = radius;
    Network network;
    network.add_instrument(instrument);
    const SurfaceShapes shapes = shapes_of(network);
    const Obstacle obstacle(network.instruments()[0]);
    CHECK(is_closed(shapes));
    // Contact rounds sharp corners by a millionth of the least side.
    const double exact = radius > 0.0 ? 1e-15 : 1e-6 * 0.5;
    for (const Vector3& point : shapes.points) CHECK(std::abs(obstacle.gap(Pose{}, point)) <= exact);
    // Of a rounded box: core, slabs on its faces, quarters of cylinders, eighths of a ball.
    const Vector3 core = instrument.box->size - 2.0 * radius * Vector3::Ones();
    const double slabs = core.x() * core.y() + core.y() * core.z() + core.z() * core.x();
    const double expected = core.prod() + 2.0 * radius * slabs + std::numbers::pi * radius * radius * core.sum() +
                            4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
    const double volume = enclosed_volume(shapes);
    if (radius == 0.0) {
      CHECK(shapes.points.size() == 8);
      CHECK(shapes.triangles.size() == 12);
      CHECK(volume == doctest::Approx(expected).epsilon(1e-14));
    }
    CHECK(volume < expected * (1.0 + 1e-14));
    CHECK(volume > 0.98 * expected);  // chords of 15 degrees, as above, of the rounded parts
  }
}

TEST_CASE("a plane is a square below the network that faces the free side") {
  Network network;
  Node node;
  node.position = Vector3(3.0, 1.0, 2.0);
  network.add_node(node);
  node.position = Vector3(5.0, 2.0, 4.0);
  network.add_node(node);
  network.add_plane({"floor", Vector3(0.5, 0.0, 1.0), Vector3(0.1, 0.2, 1.0), {}, std::nullopt});
  network.add_instrument({"", Vector3(9, 9, 9), Vector3(9, 9, 9), 0.5, {}, std::nullopt});
  const SurfaceShapes shapes = shapes_of(network);
  const Plane& plane = network.planes()[0];
  REQUIRE(shapes.points.size() > 4);
  Vector3 middle = Vector3::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(shapes.point_surface[k] == 0);
    CHECK((shapes.points[k] - plane.point).dot(plane.normal) == doctest::Approx(0.0));
    middle += shapes.points[k] / 4.0;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const Face& t = shapes.triangles[k];
    const Vector3 normal = (shapes.points[t[1]] - shapes.points[t[0]]).cross(shapes.points[t[2]] - shapes.points[t[0]]);
    CHECK(normal.normalized().dot(plane.normal) == doctest::Approx(1.0));
  }
  // Both nodes, projected, lie in the square: their distances from its middle are below half its side, the extent 3 m.
  const double side = (shapes.points[1] - shapes.points[0]).norm();
  CHECK(side == doctest::Approx(2.0 * 3.0));
  for (const Node& each : network.nodes()) {
    const Vector3 foot = each.position - (each.position - plane.point).dot(plane.normal) * plane.normal;
    CHECK((foot - middle).norm() < side / 2.0);
  }
  CHECK(shapes.point_surface.back() == 1);
  CHECK(shapes.triangle_surface.back() == 1);
}
