// Surfaces that nodes do not pass: planes, spheres and capsules, each of which may move without turning.
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include <springnet/network.hpp>

#include "network/trajectory.hpp"

namespace springnet {

using Matrix3 = Eigen::Matrix3d;

class Surface {
 public:
  explicit Surface(const Plane& plane);
  explicit Surface(const Instrument& instrument);

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  // "plane 'floor'", "instrument 2"; `number` counts its own kind.
  [[nodiscard]] std::string description(std::size_t number) const;
  [[nodiscard]] bool is_plane() const noexcept { return radius_ == 0.0; }
  [[nodiscard]] const Friction& friction() const noexcept { return friction_; }
  // A plane's point, an instrument's first point, where it starts; m.
  [[nodiscard]] const Vector3& origin() const noexcept { return origin_; }
  [[nodiscard]] const Trajectory& trajectory() const noexcept { return trajectory_; }
  void set_trajectory(Trajectory trajectory) { trajectory_ = std::move(trajectory); }

  // In the surface's own frame, x less its displacement. Distance, > 0 where nodes may be; m.
  [[nodiscard]] double distance(const Vector3& x) const;
  // Its gradient, and that one's derivative (1/m): how the direction turns along the surface.
  [[nodiscard]] Vector3 normal(const Vector3& x) const;
  [[nodiscard]] Matrix3 curvature(const Vector3& x) const;
  // The share of the straight way from `a` (outside) to `b` at which it first touches; empty if it does not. The
  // distance is convex along a line, because the surface bounds a convex body.
  [[nodiscard]] std::optional<double> first_touch(const Vector3& a, const Vector3& b) const;

 private:
  // From the nearest point of the plane's or capsule's core.
  [[nodiscard]] Vector3 from_core(const Vector3& x, bool* between_ends = nullptr) const;

  std::string name_;
  Friction friction_;
  Vector3 origin_;
  Vector3 axis_ = Vector3::Zero();  // m: from the first to the second point of a capsule
  Vector3 normal_ = Vector3::UnitZ();
  double radius_ = 0.0;  // m; 0: a plane
  Trajectory trajectory_;
};

// What is wrong with a node (user's number) that starts `depth` (m) behind a plane or inside an instrument, which is
// described as `surface`.
[[nodiscard]] std::string misplaced(NodeIndex node, double depth, bool plane, const std::string& surface);

}  // namespace springnet
