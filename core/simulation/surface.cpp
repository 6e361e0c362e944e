#include "simulation/surface.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace springnet {

Surface::Surface(const Plane& plane)
    : name_(plane.name), friction_(plane.friction), origin_(plane.point), normal_(plane.normal) {
  if (plane.motion) trajectory_ = Trajectory(*plane.motion);
}

Surface::Surface(const Instrument& instrument)
    : name_(instrument.name),
      friction_(instrument.friction),
      origin_(instrument.first),
      axis_(instrument.second - instrument.first),
      radius_(instrument.radius) {
  if (instrument.motion) trajectory_ = Trajectory(*instrument.motion);
}

std::string Surface::description(std::size_t number) const {
  const char* kind = is_plane() ? "plane" : "instrument";
  return name_.empty() ? fmt::format("{} {}", kind, number) : fmt::format("{} '{}' (number {})", kind, name_, number);
}

Vector3 Surface::from_core(const Vector3& x, bool* between_ends) const {
  const Vector3 d = x - origin_;
  const double square = axis_.squaredNorm();
  const double along = square > 0.0 ? d.dot(axis_) / square : 0.0;
  if (between_ends != nullptr) *between_ends = along > 0.0 && along < 1.0;
  return d - std::clamp(along, 0.0, 1.0) * axis_;
}

double Surface::distance(const Vector3& x) const {
  return is_plane() ? normal_.dot(x - origin_) : from_core(x).norm() - radius_;
}

Vector3 Surface::normal(const Vector3& x) const {
  if (is_plane()) return normal_;
  const Vector3 d = from_core(x);
  const double length = d.norm();
  // On the core itself any direction is as good; a node can only be there for a moment of an iteration.
  return length > 0.0 ? Vector3(d / length) : axis_.isZero(0.0) ? Vector3::UnitZ() : axis_.unitOrthogonal();
}

Matrix3 Surface::curvature(const Vector3& x) const {
  if (is_plane()) return Matrix3::Zero();
  bool between = false;
  const Vector3 d = from_core(x, &between);
  const double length = d.norm();
  if (!(length > 0.0)) return Matrix3::Zero();
  const Vector3 n = d / length;
  Matrix3 result = Matrix3::Identity() - n * n.transpose();
  if (between) {
    const Vector3 e = axis_.normalized();
    result -= e * e.transpose();
  }
  return result / length;
}

std::optional<double> Surface::first_touch(const Vector3& a, const Vector3& b) const {
  const double before = distance(a), after = distance(b);
  if (before <= 0.0) return after < 0.0 ? std::optional(0.0) : std::nullopt;
  const auto at = [&](double share) { return distance(a + share * (b - a)); };
  double outside = 0.0, inside = 1.0;
  if (after >= 0.0) {
    // The distance changes by no more than the way: most nodes are too far off to have touched on it.
    if (is_plane() || before + after >= (b - a).norm()) return std::nullopt;
    // The least distance on the way, by golden section; it counts where it is below zero.
    constexpr double golden = 0.6180339887498949;
    double low = 0.0, high = 1.0;
    double x1 = 1.0 - golden, x2 = golden, f1 = at(x1), f2 = at(x2);
    for (int i = 0; i < 60 && f1 >= 0.0 && f2 >= 0.0; ++i) {
      if (f1 < f2) {
        high = x2;
        x2 = x1;
        f2 = f1;
        f1 = at(x1 = high - golden * (high - low));
      } else {
        low = x1;
        x1 = x2;
        f1 = f2;
        f2 = at(x2 = low + golden * (high - low));
      }
    }
    if (f1 >= 0.0 && f2 >= 0.0) return std::nullopt;
    inside = f1 < 0.0 ? x1 : x2;
  }
  if (is_plane()) return before / (before - after);
  for (int i = 0; i < 60 && inside - outside > 1e-15; ++i) {
    const double middle = 0.5 * (outside + inside);
    (at(middle) < 0.0 ? inside : outside) = middle;
  }
  return outside;
}

std::string misplaced(NodeIndex node, double depth, bool plane, const std::string& surface) {
  return fmt::format("node {} starts {:.3g} m {} {}, where no node can be; move the body or the {}", node, depth,
                     plane ? "behind" : "inside", surface,
                     plane ? "plane, or turn the plane's normal towards the body" : "instrument");
}

}  // namespace springnet
