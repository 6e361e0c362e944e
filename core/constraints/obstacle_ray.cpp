// Where a ray meets the surface of an obstacle.
#include "constraints/obstacle.hpp"

#include <cmath>
#include <limits>

namespace springnet {
namespace {

// The part of a line x = from + t direction within a convex body; empty if it is outside of it.
struct Stretch {
  double begin = std::numeric_limits<double>::infinity(), end = -std::numeric_limits<double>::infinity();
  [[nodiscard]] bool empty() const { return !(begin <= end); }
  // With that within another body, where both together are convex.
  void add(const Stretch& other) {
    if (other.empty()) return;
    begin = std::min(begin, other.begin);
    end = std::max(end, other.end);
  }
};

// direction: of length 1
Stretch within_ball(const Vector3& from, const Vector3& direction, const Vector3& centre, double radius) {
  const Vector3 d = from - centre;
  const double middle = -d.dot(direction);
  // The distance of the line from the centre, without the cancellation of |d|^2 - middle^2 far away.
  const double square = radius * radius - (d + middle * direction).squaredNorm();
  if (square < 0.0) return {};
  return {middle - std::sqrt(square), middle + std::sqrt(square)};
}

// All points within `radius` of a segment.
Stretch within_capsule(const Vector3& from, const Vector3& direction, const Vector3& first, const Vector3& axis,
                       double radius) {
  Stretch result = within_ball(from, direction, first, radius);
  const double length = axis.norm();
  if (!(length > 0.0)) return result;
  result.add(within_ball(from, direction, first + axis, radius));
  const Vector3 unit = axis / length, d = from - first;
  const double start = d.dot(unit), slope = direction.dot(unit);
  const Vector3 across = direction - slope * unit, off = d - start * unit;
  Stretch wall{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  if (const double square = across.squaredNorm(); square > 0.0) {
    const double middle = -off.dot(across) / square;
    const double inside = radius * radius - (off + middle * across).squaredNorm();
    if (inside < 0.0) return result;
    const double half = std::sqrt(inside / square);
    wall = {middle - half, middle + half};
  } else if (off.squaredNorm() > radius * radius) {
    return result;
  }
  if (slope != 0.0) {
    const double a = -start / slope, b = (length - start) / slope;
    wall.begin = std::max(wall.begin, std::min(a, b));
    wall.end = std::min(wall.end, std::max(a, b));
  } else if (start < 0.0 || start > length) {
    return result;
  }
  result.add(wall);
  return result;
}

// A box about the origin along the axes.
Stretch within_box(const Vector3& from, const Vector3& direction, const Vector3& half) {
  Stretch result{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (direction[i] == 0.0) {
      if (std::abs(from[i]) > half[i]) return {};
      continue;
    }
    const double a = (-half[i] - from[i]) / direction[i], b = (half[i] - from[i]) / direction[i];
    result.begin = std::max(result.begin, std::min(a, b));
    result.end = std::min(result.end, std::max(a, b));
  }
  return result;
}

// All points within `radius` of a box: the box grown along each axis, and capsules along its edges.
Stretch within_rounded_box(const Vector3& from, const Vector3& direction, const Vector3& half, double radius) {
  Stretch result;
  for (Eigen::Index i = 0; i < 3; ++i) result.add(within_box(from, direction, half + radius * Vector3::Unit(i)));
  for (Eigen::Index i = 0; radius > 0.0 && i < 3; ++i) {
    const Eigen::Index j = (i + 1) % 3, k = (i + 2) % 3;
    for (const double at_j : {-half[j], half[j]})
      for (const double at_k : {-half[k], half[k]}) {
        Vector3 first;
        first[i] = -half[i];
        first[j] = at_j;
        first[k] = at_k;
        result.add(within_capsule(from, direction, first, 2.0 * half[i] * Vector3::Unit(i), radius));
      }
  }
  return result;
}

}  // namespace

std::optional<double> Obstacle::meets(const Pose& pose, const Vector3& from, const Vector3& direction) const {
  const Vector3 x = pose.to_start(from);
  const Vector3 d = pose.turns ? Vector3(pose.rotation.transpose() * direction) : direction;
  Stretch inside;
  if (shape_ == Shape::plane) {
    const double slope = normal_.dot(d), height = normal_.dot(x - origin_);
    if (slope == 0.0) return std::nullopt;
    const double at = -height / slope;
    return at >= 0.0 ? std::optional<double>(at) : std::nullopt;
  }
  if (shape_ == Shape::capsule)
    inside = within_capsule(x, d, origin_, axis_, radius_);
  else
    inside = within_rounded_box(axes_.transpose() * (x - origin_), axes_.transpose() * d, half_, radius_);
  if (inside.empty() || inside.end < 0.0) return std::nullopt;
  return inside.begin >= 0.0 ? inside.begin : inside.end;
}

}  // namespace springnet
