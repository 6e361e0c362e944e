// Surfaces at a place and a time that are variables: gaps, normals and velocities with their derivatives.
#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include <springnet/sdk/dual.hpp>

#include "constraints/contact.hpp"
#include "network/invariant_values.hpp"

namespace springnet::learning {

// A node over a step from (p, v) at t0 to (P, U) at t1: by p, v, V, and by P, on which normals depend, by t0 and t1,
// and by the friction of its first and its second surface.
inline constexpr std::size_t by_p = 0, by_v = 3, by_free = 6, by_end = 9, by_start_time = 12, by_end_time = 13,
                             by_first_friction = 14, by_second_friction = 15, surface_variables = 16;
using Number = sdk::Dual<surface_variables>;
using Vector = invariants::Triple<Number>;
using Changes = Eigen::Matrix<double, 3, static_cast<int>(surface_variables)>;

[[nodiscard]] inline Vector3 value_of(const Vector& x) { return {x.x.value, x.y.value, x.z.value}; }
[[nodiscard]] inline Changes changes_of(const Vector& x) {
  Changes result;
  for (std::size_t k = 0; k < surface_variables; ++k)
    result.col(static_cast<Eigen::Index>(k)) << x.x.derivatives[k], x.y.derivatives[k], x.z.derivatives[k];
  return result;
}
[[nodiscard]] inline Number number_of(double value,
                                      const Eigen::Matrix<double, 1, static_cast<int>(surface_variables)>& changes) {
  Number result(value);
  for (std::size_t k = 0; k < surface_variables; ++k) result.derivatives[k] = changes[static_cast<Eigen::Index>(k)];
  return result;
}
[[nodiscard]] inline Vector vector_of(const Vector3& value, const Changes& changes) {
  return {number_of(value[0], changes.row(0)), number_of(value[1], changes.row(1)),
          number_of(value[2], changes.row(2))};
}
[[nodiscard]] inline Vector variable(const Vector3& value, std::size_t first) {
  return {Number::variable(value[0], first), Number::variable(value[1], first + 1),
          Number::variable(value[2], first + 2)};
}
[[nodiscard]] inline Vector constant(const Vector3& value) { return vector_of(value, Changes::Zero()); }
[[nodiscard]] inline Vector times(double factor, const Vector& x) { return Number(factor) * x; }
[[nodiscard]] inline Vector times(const Matrix3& matrix, const Vector& x) {
  return vector_of(matrix * value_of(x), matrix * changes_of(x));
}
[[nodiscard]] inline Number length(const Vector& x) { return sqrt(dot(x, x)); }

// Surfaces at one time, which is the variable `time`.
class SurfaceNumbers {
 public:
  SurfaceNumbers(const Contact& contact, const Placement& at, std::size_t time)
      : contact_(contact), at_(at), time_(static_cast<Eigen::Index>(time)) {}

  [[nodiscard]] Number gap(std::int32_t j, const Vector& x) const {
    const Vector3 place = value_of(x), n = contact_.normal(at_, index(j), place);
    Eigen::Matrix<double, 1, static_cast<int>(surface_variables)> changes = n.transpose() * changes_of(x);
    changes[time_] -= n.dot(Contact::velocity(at_, index(j), place));
    return number_of(contact_.gap(at_, index(j), place), changes);
  }
  // A point of the surface carries its normal along.
  [[nodiscard]] Vector normal(std::int32_t j, const Vector& x) const {
    const Obstacle& obstacle = contact_.obstacles()[index(j)];
    const Pose& pose = at_.poses[index(j)];
    const Vector3 place = value_of(x), n = obstacle.normal(pose, place);
    const Matrix3 curvature = obstacle.curvature(pose, place);
    Changes changes = curvature * changes_of(x);
    changes.col(time_) -= curvature * pose.velocity_at(place);
    if (pose.turns) changes.col(time_) += pose.spin.cross(n);
    return vector_of(n, changes);
  }
  [[nodiscard]] Vector onto(std::int32_t j, const Vector& x) const { return x - gap(j, x) * normal(j, x); }
  [[nodiscard]] Vector velocity(std::int32_t j, const Vector& x) const {
    const Pose& pose = at_.poses[index(j)];
    const Vector3 place = value_of(x), w = pose.velocity_at(place);
    const Changes own = changes_of(x);
    Changes changes = Changes::Zero();
    for (Eigen::Index k = 0; pose.turns && k < own.cols(); ++k) changes.col(k) = pose.spin.cross(Vector3(own.col(k)));
    changes.col(time_) += pose.acceleration_at(place);
    if (pose.turns) changes.col(time_) -= pose.spin.cross(w);
    return vector_of(w, changes);
  }

 private:
  [[nodiscard]] static std::size_t index(std::int32_t surface) { return static_cast<std::size_t>(surface); }

  const Contact& contact_;
  const Placement& at_;
  Eigen::Index time_;
};

}  // namespace springnet::learning
