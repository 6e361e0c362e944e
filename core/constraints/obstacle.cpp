#include "constraints/obstacle.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "constraints/path_minimum.hpp"
#include "network/kinks.hpp"
#include "network/rotation.hpp"

namespace springnet {

Vector3 Pose::to_start(const Vector3& x) const {
  const Vector3 y = x - displacement;
  return turns ? Vector3(pivot + rotation.transpose() * (y - pivot)) : y;
}

Vector3 Pose::from_start(const Vector3& x) const {
  return turns ? Vector3(pivot + displacement + rotation * (x - pivot)) : Vector3(x + displacement);
}

Vector3 Pose::velocity_at(const Vector3& x) const {
  return turns ? Vector3(velocity + spin.cross(x - pivot - displacement)) : velocity;
}

Vector3 Pose::acceleration_at(const Vector3& x) const {
  if (!turns) return acceleration;
  const Vector3 arm = x - pivot - displacement;
  return acceleration + spin_acceleration.cross(arm) + spin.cross(spin.cross(arm));
}

Obstacle::Obstacle(const Plane& plane)
    : name_(plane.name),
      friction_(plane.friction),
      restitution_(plane.restitution),
      shape_(Shape::plane),
      origin_(plane.point),
      normal_(plane.normal),
      pivot_(plane.point) {
  follow(plane.motion, plane.turn);
}

Obstacle::Obstacle(const Instrument& instrument)
    : name_(instrument.name),
      friction_(instrument.friction),
      restitution_(instrument.restitution),
      shape_(instrument.box ? Shape::box : Shape::capsule),
      origin_(instrument.first),
      radius_(instrument.radius),
      pivot_(instrument.first) {
  if (instrument.box) {
    constexpr double sharp = 1e-6;  // of the smallest size: not distinguishable from a sharp edge
    axes_ = instrument.box->axes;
    radius_ = std::max(instrument.box->radius, sharp * instrument.box->size.minCoeff());
    half_ = 0.5 * instrument.box->size - Vector3::Constant(radius_);
  } else {
    axis_ = instrument.second - instrument.first;
  }
  follow(instrument.motion, instrument.turn);
}

void Obstacle::follow(const std::optional<Motion>& motion, const std::optional<Turn>& turn) {
  if (motion) trajectory_ = Trajectory(*motion);
  looks_sampled_ = (motion && kinks_of(*motion).look_sampled()) || (turn && kinks_of(*turn).look_sampled());
  if (!turn) return;
  turning_ = Turning(*turn);
  turn_axis_ = turn->axis;
  if (turn->through) pivot_ = *turn->through;
  turns_in_place_ = is_symmetric_about_turn();
}

bool Obstacle::is_symmetric_about_turn() const {
  constexpr double rounding = 1e-12;
  const Vector3& axis = turn_axis_;
  if (shape_ == Shape::plane) return axis.cross(normal_).norm() <= rounding;
  if (shape_ == Shape::box) return false;
  const double size = radius_ + axis_.norm();
  return axis.cross(origin_ - pivot_).norm() <= rounding * size && axis.cross(axis_).norm() <= rounding * size;
}

std::string Obstacle::description(std::size_t number) const {
  const char* kind = is_plane() ? "plane" : "instrument";
  return name_.empty() ? fmt::format("{} {}", kind, number) : fmt::format("{} '{}' (number {})", kind, name_, number);
}

Pose Obstacle::at(const SampleTime& time) const {
  const Trajectory::Sample moved = sample(trajectory_, time);
  Pose pose;
  pose.displacement = moved.displacement;
  pose.velocity = moved.velocity;
  pose.acceleration = moved.acceleration;
  if (!turns()) return pose;
  const Turning::Sample turned = sample(turning_, time);
  pose.turns = true;
  pose.pivot = pivot_;
  pose.rotation = rotation_about(turn_axis_, turned.angle);
  pose.spin = turned.rate * turn_axis_;
  pose.spin_acceleration = turned.acceleration * turn_axis_;
  return pose;
}

Vector3 Obstacle::displacement_to(const Vector3& position, double time) const {
  Pose turned = at(just_after(time));
  turned.displacement.setZero();
  return position - turned.from_start(origin_);
}

double Obstacle::gap(const Pose& pose, const Vector3& x) const { return gap(pose.to_start(x)); }

Vector3 Obstacle::normal(const Pose& pose, const Vector3& x) const {
  const Vector3 n = normal(pose.to_start(x));
  return pose.turns ? Vector3(pose.rotation * n) : n;
}

Matrix3 Obstacle::curvature(const Pose& pose, const Vector3& x) const {
  const Matrix3 h = curvature(pose.to_start(x));
  return pose.turns ? Matrix3(pose.rotation * h * pose.rotation.transpose()) : h;
}

// In the obstacle's frame the point has the velocity R^T relative and the acceleration R^T (a - acceleration_at - 2
// spin x relative): curvature and Coriolis terms.
double Obstacle::bias_acceleration(const Pose& pose, const Vector3& x, const Vector3& relative) const {
  double result = is_flat() ? 0.0 : relative.dot(curvature(pose, x) * relative);
  if (pose.turns) result -= 2.0 * normal(pose, x).dot(pose.spin.cross(relative));
  return result;
}

double Obstacle::seam(const Pose& pose, const Vector3& x) const {
  const Vector3 place = pose.to_start(x);
  if (shape_ == Shape::box) {
    // The number of pairs of faces that the point is beyond changes where the middle or the smallest value changes its
    // sign.
    Vector3 beyond = beyond_faces(place);
    std::sort(beyond.begin(), beyond.end());
    return std::min(beyond[1], -beyond[0]);
  }
  const double length = axis_.norm();
  if (length == 0.0) return std::numeric_limits<double>::infinity();  // a plane, a sphere
  const double along = (place - origin_).dot(axis_) / length;
  return std::min(along, length - along);
}

Vector3 Obstacle::onto(const Pose& pose, const Vector3& x) const { return x - gap(pose, x) * normal(pose, x); }

std::optional<double> Obstacle::first_touch(const Pose& before, const Vector3& a, const Pose& after,
                                            const Vector3& b) const {
  return first_touch(before.to_start(a), after.to_start(b));
}

double Obstacle::inscribed_radius() const {
  return is_plane() ? std::numeric_limits<double>::infinity()
                    : radius_ + (shape_ == Shape::box ? half_.minCoeff() : 0.0);
}

double Obstacle::min_gap(const Pose& pose, const Vector3& x) const {
  const Vector3 swing = 2.0 * trajectory_.amplitude();
  double least = gap(pose, x) - (is_plane() && !turns() ? std::abs(normal_.dot(swing)) : swing.norm());
  if (!pose.turns || turns_in_place()) return least;
  if (is_plane()) return -std::numeric_limits<double>::infinity();
  // The obstacle stays within a ball about the pivot.
  const double extent = (origin_ - pivot_).norm() + axis_.norm() + half_.norm() + radius_;
  return (x - pivot_ - pose.displacement).norm() - extent - swing.norm();
}

Vector3 Obstacle::from_core(const Vector3& x, bool* between_ends) const {
  const Vector3 d = x - origin_;
  const double square = axis_.squaredNorm();
  const double along = square > 0.0 ? d.dot(axis_) / square : 0.0;
  if (between_ends != nullptr) *between_ends = along > 0.0 && along < 1.0;
  return d - std::clamp(along, 0.0, 1.0) * axis_;
}

Vector3 Obstacle::beyond_faces(const Vector3& x) const {
  return (axes_.transpose() * (x - origin_)).cwiseAbs() - half_;
}

Vector3 Obstacle::out_of_core(const Vector3& x, const Vector3& beyond) const {
  Vector3 out = beyond.cwiseMax(0.0);
  if (const double length = out.norm(); length > 0.0) {
    out /= length;
  } else {
    Eigen::Index nearest = 0;
    beyond.maxCoeff(&nearest);
    out = Vector3::Unit(nearest);
  }
  const Vector3 place = axes_.transpose() * (x - origin_);
  for (Eigen::Index i = 0; i < 3; ++i) out[i] = std::copysign(out[i], place[i]);
  return out;
}

double Obstacle::gap(const Vector3& x) const {
  if (shape_ == Shape::plane) return normal_.dot(x - origin_);
  if (shape_ == Shape::capsule) return from_core(x).norm() - radius_;
  const Vector3 beyond = beyond_faces(x);
  return std::min(beyond.maxCoeff(), 0.0) + beyond.cwiseMax(0.0).norm() - radius_;
}

Vector3 Obstacle::normal(const Vector3& x) const {
  if (shape_ == Shape::plane) return normal_;
  if (shape_ == Shape::box) return axes_ * out_of_core(x, beyond_faces(x));
  const Vector3 d = from_core(x);
  const double length = d.norm();
  // On the core any direction will do; a node can be there only in the course of an iteration.
  return length > 0.0 ? Vector3(d / length) : axis_.isZero(0.0) ? Vector3::UnitZ() : axis_.unitOrthogonal();
}

Matrix3 Obstacle::curvature(const Vector3& x) const {
  if (shape_ == Shape::plane) return Matrix3::Zero();
  if (shape_ == Shape::box) {
    // Beyond one pair of faces the surface is flat; beyond two the nearest point of the core is on an edge, beyond
    // three on a corner.
    const Vector3 beyond = beyond_faces(x), bends = (beyond.array() > 0.0).cast<double>();
    if (bends.sum() < 2.0) return Matrix3::Zero();
    const Vector3 n = out_of_core(x, beyond);
    const Matrix3 along = bends.asDiagonal();
    return axes_ * ((along - n * n.transpose()) / beyond.cwiseMax(0.0).norm()) * axes_.transpose();
  }
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

std::optional<double> Obstacle::first_touch(const Vector3& a, const Vector3& b) const {
  const double before = gap(a), after = gap(b);
  if (before <= 0.0) return after < 0.0 ? std::optional(0.0) : std::nullopt;
  const auto at = [&](double share) { return gap(a + share * (b - a)); };
  double outside = 0.0, inside = 1.0;
  if (after >= 0.0) {
    // The gap changes by at most the path length: most nodes are too far away to touch.
    if (is_plane() || before + after >= (b - a).norm()) return std::nullopt;
    // The path may dip below the surface in between: search the smallest gap.
    const PathMinimum least = minimum_on_path(at, 0.0, 60);
    if (least.value >= 0.0) return std::nullopt;
    inside = least.share;
  }
  if (is_plane()) return before / (before - after);
  for (int i = 0; i < 60 && inside - outside > 1e-15; ++i) {
    const double middle = 0.5 * (outside + inside);
    (at(middle) < 0.0 ? inside : outside) = middle;
  }
  return outside;
}

double size_of(const Network& network) {
  double size = 0.0;
  const auto include = [&](const Vector3& x) { size = std::max(size, x.cwiseAbs().maxCoeff()); };
  for (const Node& node : network.nodes()) include(node.position);
  for (const Plane& plane : network.planes()) include(plane.point);
  for (const Instrument& instrument : network.instruments()) include(instrument.first);
  return size;
}

double starting_depth(const Obstacle& obstacle, const Pose& pose, const Vector3& x, double size) {
  // Above the rounding of coordinates, below any intended depth.
  constexpr double coincidence = 1e-9;
  const double depth = -obstacle.gap(pose, x);
  return depth > coincidence * size ? depth : 0.0;
}

std::string misplaced(NodeIndex node, double depth, bool plane, const std::string& surface) {
  return fmt::format("node {} starts {:.3g} m {} {}; move the body or the {}", node, depth, plane ? "behind" : "inside",
                     surface, plane ? "plane, or turn the plane's normal towards the body" : "instrument");
}

}  // namespace springnet
