#include "constraints/friction.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <springnet/sdk/math.hpp>

#include "constraints/least_squares.hpp"

namespace springnet {

Friction bounded(const Friction& friction) noexcept {
  return friction.kind == Friction::Kind::held ? Friction{Friction::Kind::coulomb, friction_of_held} : friction;
}

double coefficient_of(const Friction& friction) noexcept {
  switch (friction.kind) {
    case Friction::Kind::none:
      return 0.0;
    case Friction::Kind::coulomb:
      return friction.coefficient;
    case Friction::Kind::held:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

double sliding_coefficient_of(const Friction& friction) noexcept {
  return std::min(coefficient_of(friction), friction_of_held);
}

double friction_limit(double coefficient, double normal_force) noexcept {
  return std::isinf(coefficient) ? coefficient : coefficient * normal_force;
}

double cone_margin(double coefficient, double normal_force, double tangential_force) noexcept {
  if (std::isinf(coefficient)) return normal_force >= 0.0 ? coefficient : -tangential_force;
  return friction_limit(coefficient, normal_force) - tangential_force;
}

Eigen::Matrix3d friction_by_velocity(double strength, const Vector3& slip, const Vector3& n) {
  const double speed = slip.norm();
  if (!(speed > 0.0)) return Eigen::Matrix3d::Zero();
  const Vector3 t = slip / speed;
  return -strength / speed * (Eigen::Matrix3d::Identity() - n * n.transpose() - t * t.transpose());
}

std::optional<Vector3> find_direction(const Vector3& n, const Vector3& start,
                                      const std::function<double(const Vector3&)>& residual) {
  const Vector3 across = n.cross(start);
  const auto at = [&](double angle) { return Vector3(sdk::cos(angle) * start + sdk::sin(angle) * across); };
  constexpr int max_iterations = 40;
  constexpr double first = 1e-3, longest = 0.5;  // rad
  double before = 0.0, value_before = residual(start), angle = value_before == 0.0 ? 0.0 : first;
  for (int i = 0; i < max_iterations; ++i) {
    const double value = residual(at(angle));
    if (!std::isfinite(value)) return std::nullopt;
    if (value == 0.0 || angle == before) return at(angle);
    const double slope = (value - value_before) / (angle - before);
    // Equal values: the difference is below rounding.
    if (slope == 0.0) return std::abs(angle - before) <= 1e-7 ? std::optional(at(angle)) : std::nullopt;
    const double step = std::clamp(-value / slope, -longest, longest);
    before = angle;
    value_before = value;
    angle += step;
    if (std::abs(step) <= 1e-15) return at(angle);
  }
  return std::abs(angle - before) <= 1e-9 ? std::optional(at(angle)) : std::nullopt;
}

ContactResponse solve_contact(const Eigen::Matrix3d& mobility, const Vector3& relative, const Vector3& n,
                              const Friction& friction, double more) {
  if (!(n.dot(mobility * n) > 0.0)) return {relative, Vector3::Zero(), 0.0, false};
  const auto smooth = [&] {
    const double impulse = -n.dot(relative) / n.dot(mobility * n);
    return ContactResponse{relative + mobility * n * impulse, n * impulse, impulse, false};
  };
  if (friction.kind == Friction::Kind::none) return smooth();
  // A node that cannot move in every direction: least-squares solution within those in which it can.
  const double size = mobility.norm();
  const bool regular = mobility.determinant() > 1e-9 * size * size * size;
  const Vector3 stop =
      regular ? Vector3(-(mobility.inverse() * relative)) : Vector3(-least_squares(mobility, relative));
  const double normal_impulse = n.dot(stop);
  Vector3 tangential = stop - normal_impulse * n;
  if (friction.kind == Friction::Kind::held) return {Vector3::Zero(), stop, normal_impulse, true};
  ContactResponse without = smooth();
  if (without.normal <= 0.0 || without.normal + more <= 0.0) return without;
  if (normal_impulse > 0.0 && cone_margin(friction.coefficient, normal_impulse + more, tangential.norm()) >= 0.0)
    return {Vector3::Zero(), stop, normal_impulse, true};
  // Slip: impulse p n - mu (p + more) t, t the direction of the remaining slip. An anisotropic mobility lets the
  // impulse turn t; with an isotropic one the first t is exact.
  const auto with = [&](const Vector3& t) {
    const Vector3 direction = n - friction.coefficient * t;
    const Vector3 known = -friction.coefficient * more * t;
    const double impulse = -n.dot(relative + mobility * known) / n.dot(mobility * direction);
    return ContactResponse{relative + mobility * direction * impulse + mobility * known, direction * impulse + known,
                           impulse, false};
  };
  const auto slip_of = [&](const ContactResponse& answer) {
    return Vector3(answer.velocity - n * n.dot(answer.velocity));
  };
  const Vector3 slip = slip_of(without);
  Vector3 t = slip.norm() > 0.0 ? Vector3(slip.normalized()) : Vector3(-tangential.normalized());
  constexpr int max_iterations = 50;
  for (int i = 0; i < max_iterations; ++i) {
    const ContactResponse answer = with(t);
    const Vector3 left = slip_of(answer);
    if (!(answer.normal > 0.0) || left.dot(t) <= 0.0) break;
    const double turned = (left.normalized() - t).norm();
    t = left.normalized();
    if (turned <= 1e-14) return answer;
  }
  // Find t for which the remaining slip is parallel to t: near the last one first, else by bisection around the full
  // circle.
  const auto fits = [&](const Vector3& assumed) {
    const ContactResponse answer = with(assumed);
    return answer.normal > 0.0 && slip_of(answer).dot(assumed) > 0.0;
  };
  const auto across = [&](const Vector3& assumed) { return n.dot(assumed.cross(slip_of(with(assumed)))); };
  if (const std::optional<Vector3> near = find_direction(n, t, across); near && fits(*near)) return with(*near);
  constexpr int directions = 128;
  const Vector3 e = n.unitOrthogonal();
  const double step = 2.0 * std::numbers::pi / directions, cosine = sdk::cos(step), sine = sdk::sin(step);
  Vector3 low = e;
  double value = across(low);
  for (int i = 0; i < directions; ++i) {
    const Vector3 high = i + 1 < directions ? Vector3((cosine * low + sine * n.cross(low)).normalized()) : e;
    const double next = across(high);
    if (value * next <= 0.0) {
      Vector3 a = low, b = high;
      for (int halving = 0; halving < 60; ++halving) {
        const Vector3 middle = (a + b).normalized();
        (across(middle) * value > 0.0 ? a : b) = middle;
      }
      if (fits(a)) return with(a);
    }
    low = high;
    value = next;
  }
  // Great friction and a very anisotropic mobility: no slip direction fits, so the node is stopped.
  return {Vector3::Zero(), stop, std::max(normal_impulse, 0.0), true};
}

}  // namespace springnet
