#include "law_course.hpp"

#include <Eigen/Dense>
#include <array>
#include <cmath>

namespace springnet::tool {

namespace {

using Point = Eigen::Vector3d;

std::array<Point, 4> regular_corners(std::uint32_t shape) {
  const double height = std::sqrt(3.0) / 2.0;
  switch (shape) {
    case SPRINGNET_CHAIN:
      return {Point(1, 0, 0), Point(0, 0, 0), Point(-0.5, height, 0), Point(0, 0, 0)};
    case SPRINGNET_HINGE:
      return {Point(0, 0, 0), Point(1, 0, 0), Point(0.5, height, 0), Point(0.5, -height, 0)};
    default:
      return {Point(0, 0, 0), Point(1, 0, 0), Point(0.5, height, 0), Point(0.5, height / 3.0, std::sqrt(2.0 / 3.0))};
  }
}

// Regular, with edges of 1 m; a chain has an angle of 120 degrees, a hinge is flat. Stretched along its first edge.
std::array<Point, 4> corners_of_shape(std::uint32_t shape, double stretch) {
  std::array<Point, 4> corners = regular_corners(shape);
  for (Point& corner : corners) corner.x() *= stretch;
  return corners;
}

double value_of(const springnet_invariant& one, const std::array<Point, 4>& corners) {
  const Point a = corners[one.corners[0]], b = corners[one.corners[1]], c = corners[one.corners[2]],
              d = corners[one.corners[3]];
  switch (one.kind) {
    case SPRINGNET_LENGTH:
      return (b - a).norm();
    case SPRINGNET_ANGLE:
      return std::acos((a - b).normalized().dot((c - b).normalized()));
    case SPRINGNET_AREA:
      return (b - a).cross(c - a).norm() / 2.0;
    case SPRINGNET_VOLUME:
      return (b - a).dot((c - a).cross(d - a)) / 6.0;
    default:
      return 0.0;  // of a flat hinge
  }
}

const char* shape_name(std::uint32_t shape) {
  switch (shape) {
    case SPRINGNET_CHAIN:
      return "A chain of two edges of 1 m at 120 degrees";
    case SPRINGNET_TRIANGLE:
      return "A regular triangle with edges of 1 m";
    case SPRINGNET_HINGE:
      return "A flat hinge of two regular triangles with edges of 1 m";
    default:
      return "A regular tetrahedron with edges of 1 m";
  }
}

}  // namespace

LawCourse::LawCourse(const springnet_law& law, double reference) {
  if (law.invariant != SPRINGNET_SEVERAL) {
    all_.push_back({{sizeof(springnet_invariant), law.invariant, {}, 0, 0}, reference});
    name_ = units(0).name;
    unit_ = units(0).unit;
    if (law.invariant == SPRINGNET_RELATIVE_SPEED) {
      all_[0].reference = x_at_rest_ = from_ = x_of_stretch_ = 0.0;
      to_ = 1.0;
      return;
    }
    x_at_rest_ = x_of_stretch_ = reference;
    from_ = 0.5 * reference;
    to_ = 1.5 * reference;
    return;
  }
  shape_ = law.shape;
  element_ = shape_name(law.shape);
  bends_ = true;
  for (std::uint32_t i = 0; i < law.invariant_count; ++i) {
    const springnet_invariant& one = *law.invariants[i];
    const bool is_angle = one.kind == SPRINGNET_ANGLE || one.kind == SPRINGNET_DIHEDRAL;
    if ((one.flags & SPRINGNET_REFERENCE_ONLY) == 0 && !is_angle) bends_ = false;
    all_.push_back({one, value_of(one, corners_of_shape(shape_, 1.0))});
  }
  name_ = bends_                         ? "change of the angle"
          : law.shape == SPRINGNET_CHAIN ? "stretch along edge 10"
                                         : "stretch along edge 01";
  unit_ = bends_ ? "rad" : "1";
  if (!bends_) return;
  x_at_rest_ = x_of_stretch_ = 0.0;
  from_ = -1.0;
  to_ = 1.0;
}

double LawCourse::value(const One& one, double stretch, double bend) const {
  const bool is_angle = one.invariant.kind == SPRINGNET_ANGLE || one.invariant.kind == SPRINGNET_DIHEDRAL;
  if (bends_) return is_angle ? one.reference + bend : one.reference;
  return value_of(one.invariant, corners_of_shape(shape_, stretch));
}

std::vector<Numbers> LawCourse::references() const {
  std::vector<Numbers> result;
  for (const One& one : all_) result.push_back({one.reference});
  return result;
}

std::vector<Numbers> LawCourse::values(const Numbers& x) const {
  if (element_.empty()) return {x};
  std::vector<Numbers> result;
  for (const One& one : all_) {
    Numbers& list = result.emplace_back();
    for (const double at : x) list.push_back(value(one, at, at));
  }
  return result;
}

std::vector<Numbers> LawCourse::rates(const Numbers& speeds) const {
  if (element_.empty()) return {speeds};
  // By central differences: an error of 1e-10 is not seen.
  constexpr double h = 1e-5;
  std::vector<Numbers> result;
  for (const One& one : all_) {
    const double slope =
        (value(one, x_at_rest_ + h, x_at_rest_ + h) - value(one, x_at_rest_ - h, x_at_rest_ - h)) / (2.0 * h);
    Numbers& list = result.emplace_back();
    for (const double speed : speeds) list.push_back(slope * speed);
  }
  return result;
}

LawCourse::Units LawCourse::units(std::size_t invariant) const {
  switch (all_[invariant].invariant.kind) {
    case SPRINGNET_RELATIVE_SPEED:
      return {"relative speed", "m/s", "N", "N s/m", ""};
    case SPRINGNET_ANGLE:
    case SPRINGNET_DIHEDRAL:
      return {"angle", "rad", "N m", "N m/rad", "N m s/rad"};
    case SPRINGNET_AREA:
      return {"area", "m\u00b2", "N/m", "N/m\u00b3", "N s/m\u00b3"};
    case SPRINGNET_VOLUME:
    case SPRINGNET_ENCLOSED_VOLUME:
      return {"volume", "m\u00b3", "Pa", "Pa/m\u00b3", "Pa s/m\u00b3"};
    default:
      return {"length", "m", "N", "N/m", "N s/m"};
  }
}

}  // namespace springnet::tool
