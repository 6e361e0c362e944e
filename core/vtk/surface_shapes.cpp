#include "vtk/surface_shapes.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

namespace springnet {

namespace {

class Builder {
 public:
  // The next points and triangles belong to this surface.
  void begin(std::uint32_t surface) { surface_ = surface; }
  NodeIndex point(const Vector3& place) {
    shapes.points.push_back(place);
    shapes.point_surface.push_back(surface_);
    return static_cast<NodeIndex>(shapes.points.size() - 1);
  }
  void triangle(NodeIndex a, NodeIndex b, NodeIndex c) {
    shapes.triangles.push_back({a, b, c});
    shapes.triangle_surface.push_back(surface_);
  }

  SurfaceShapes shapes;

 private:
  std::uint32_t surface_ = 0;
};

// Two unit vectors, perpendicular to `axis` and to each other; axis, first, second are right-handed.
std::array<Vector3, 2> perpendicular_to(const Vector3& axis) {
  const Vector3 first = axis.unitOrthogonal();
  return {first, axis.cross(first)};
}

void add_plane(Builder& builder, const Plane& plane, const Vector3& middle, double half) {
  const Vector3 foot = middle - (middle - plane.point).dot(plane.normal) * plane.normal;
  const auto [u, v] = perpendicular_to(plane.normal);
  const NodeIndex first = builder.point(foot - half * u - half * v);
  builder.point(foot + half * u - half * v);
  builder.point(foot + half * u + half * v);
  builder.point(foot - half * u + half * v);
  builder.triangle(first, first + 1, first + 2);
  builder.triangle(first, first + 2, first + 3);
}

// Rings of points from pole to pole; a capsule has two equators, one at each end.
void add_round(Builder& builder, const Instrument& instrument) {
  constexpr int around = 24;
  constexpr int half = 6;  // rings from a pole to the equator, inclusive
  const Vector3 reach = instrument.second - instrument.first;
  const bool capsule = reach.norm() > 0.0;
  const Vector3 axis = capsule ? Vector3(reach.normalized()) : Vector3::UnitZ();
  const std::array<Vector3, 2> sides = perpendicular_to(axis);
  const NodeIndex south = builder.point(instrument.first - instrument.radius * axis);
  NodeIndex last = south;
  const auto ring = [&](const Vector3& center, int step) {
    const double polar = std::numbers::pi / 2.0 * step / half;  // from the south pole
    NodeIndex begin = 0;
    for (int k = 0; k < around; ++k) {
      const double turn = 2.0 * std::numbers::pi * k / around;
      const Vector3 out =
          std::sin(polar) * (std::cos(turn) * sides[0] + std::sin(turn) * sides[1]) - std::cos(polar) * axis;
      const NodeIndex index = builder.point(center + instrument.radius * out);
      if (k == 0) begin = index;
    }
    for (NodeIndex k = 0; k < around; ++k) {
      const NodeIndex next = (k + 1) % around;
      if (last == south) {
        builder.triangle(south, begin + next, begin + k);
      } else {
        builder.triangle(last + k, last + next, begin + next);
        builder.triangle(last + k, begin + next, begin + k);
      }
    }
    last = begin;
  };
  for (int step = 1; step <= half; ++step) ring(instrument.first, step);
  for (int step = capsule ? half : half + 1; step < 2 * half; ++step) ring(instrument.second, step);
  const NodeIndex north = builder.point(instrument.second + instrument.radius * axis);
  for (NodeIndex k = 0; k < around; ++k) builder.triangle(last + k, last + (k + 1) % around, north);
}

// Rings about the third axis, from one end to the other: those of a sphere, pulled apart by the box's core. Each
// quarter of a ring belongs to one edge of the core; it is a single point at the ends and if the box has sharp edges.
void add_box(Builder& builder, const Vector3& middle, const BoxShape& box) {
  const int steps = box.radius > 0.0 ? 6 : 0;  // from one end of a quarter to the other
  const int points = steps + 1;
  const Vector3 core = 0.5 * box.size - Vector3::Constant(box.radius);
  const auto angle = [&](int step) { return steps == 0 ? 0.0 : std::numbers::pi / 2.0 * step / steps; };
  const auto ring = [&](double upward, double polar, int of_quarter) {
    std::vector<NodeIndex> indices;
    for (int edge = 0; edge < 4; ++edge) {
      const Vector3 corner(edge == 0 || edge == 3 ? core.x() : -core.x(), edge < 2 ? core.y() : -core.y(),
                           upward * core.z());
      for (int k = 0; k < of_quarter; ++k) {
        const double turn = angle(k) + std::numbers::pi / 2.0 * edge;
        const Vector3 out(std::cos(polar) * std::cos(turn), std::cos(polar) * std::sin(turn), std::sin(polar));
        indices.push_back(builder.point(middle + box.axes * (corner + box.radius * out)));
      }
      for (int k = of_quarter; k < points; ++k) indices.push_back(indices.back());
    }
    return indices;
  };
  const auto cap = [&](const std::vector<NodeIndex>& end, bool upward) {
    const auto corner = [&](std::size_t edge) { return end[edge * static_cast<std::size_t>(points)]; };
    const std::size_t second = upward ? 1 : 3, last = 4 - second;
    builder.triangle(corner(0), corner(second), corner(2));
    builder.triangle(corner(0), corner(2), corner(last));
  };
  std::vector<NodeIndex> last = ring(-1.0, -std::numbers::pi / 2.0, 1);
  cap(last, false);
  for (int step = 1; step < 2 * points; ++step) {
    const bool upper = step >= points;
    const double polar = upper ? angle(step - points) : angle(step) - std::numbers::pi / 2.0;
    const std::vector<NodeIndex> next = ring(upper ? 1.0 : -1.0, polar, step + 1 == 2 * points ? 1 : points);
    for (std::size_t k = 0; k < next.size(); ++k) {
      const std::size_t beside = (k + 1) % next.size();
      if (last[k] != last[beside]) builder.triangle(last[k], last[beside], next[beside]);
      if (next[k] != next[beside]) builder.triangle(last[k], next[beside], next[k]);
    }
    last = next;
  }
  cap(last, true);
}

}  // namespace

SurfaceShapes shapes_of(const Network& network) {
  Vector3 low = Vector3::Zero(), high = Vector3::Zero();
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    const Vector3& place = network.nodes()[k].position;
    low = k == 0 ? place : Vector3(low.cwiseMin(place));
    high = k == 0 ? place : Vector3(high.cwiseMax(place));
  }
  const double extent = (high - low).norm();
  const double half = extent > 0.0 ? extent : 1.0;  // m

  Builder builder;
  std::uint32_t surface = 0;
  for (const Plane& plane : network.planes()) {
    builder.begin(surface++);
    add_plane(builder, plane, (low + high) / 2.0, half);
  }
  for (const Instrument& instrument : network.instruments()) {
    builder.begin(surface++);
    if (instrument.box) {
      add_box(builder, instrument.first, *instrument.box);
    } else {
      add_round(builder, instrument);
    }
  }
  return std::move(builder.shapes);
}

}  // namespace springnet
