// Obstacles, which nodes do not pass: planes, spheres, capsules and boxes. Each may move and turn; where it is at a
// time is its pose, which every question is asked with.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include <Eigen/Core>

#include <springnet/network.hpp>

#include "constraints/sample_time.hpp"
#include "network/trajectory.hpp"
#include "network/turning.hpp"

namespace springnet {

using Matrix3 = Eigen::Matrix3d;

// Where a rigid obstacle is and how it moves: a point x of it at the start is now at centre + rotation (x - pivot).
struct Pose {
  Vector3 displacement = Vector3::Zero();  // m: centre - pivot
  Vector3 velocity = Vector3::Zero();      // m/s, of the centre
  Vector3 acceleration = Vector3::Zero();  // m/s^2, of the centre
  bool turns = false;                      // else what follows is not read
  Vector3 pivot = Vector3::Zero();         // m, at the start
  Matrix3 rotation = Matrix3::Identity();
  Vector3 spin = Vector3::Zero();               // rad/s
  Vector3 spin_acceleration = Vector3::Zero();  // rad/s^2

  // Where a point of the obstacle that is at `x` now was at the start, and the other way round; m.
  [[nodiscard]] Vector3 to_start(const Vector3& x) const;
  [[nodiscard]] Vector3 from_start(const Vector3& x) const;
  // Of the point of the obstacle that is at `x` now; m/s, m/s^2.
  [[nodiscard]] Vector3 velocity_at(const Vector3& x) const;
  [[nodiscard]] Vector3 acceleration_at(const Vector3& x) const;
};

class Obstacle {
 public:
  explicit Obstacle(const Plane& plane);
  explicit Obstacle(const Instrument& instrument);

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  // "plane 'floor'", "instrument 2"; `number` counts its own kind.
  [[nodiscard]] std::string description(std::size_t number) const;
  [[nodiscard]] bool is_plane() const noexcept { return shape_ == Shape::plane; }
  // Its normal has the same direction everywhere.
  [[nodiscard]] bool is_flat() const noexcept { return is_plane(); }
  [[nodiscard]] const Friction& friction() const noexcept { return friction_; }
  // The share of its normal velocity with which a node that hits it leaves again, 0 to 1.
  [[nodiscard]] double restitution() const noexcept { return restitution_; }
  // A plane's point, an instrument's first point, a box's middle, where it starts; m.
  [[nodiscard]] const Vector3& origin() const noexcept { return origin_; }
  [[nodiscard]] bool moves() const noexcept { return trajectory_.moves() || turns(); }
  [[nodiscard]] bool turns() const noexcept { return turning_.turns(); }
  // It turns about an axis of its own symmetry, so that its shape stays where it is: a drill, a turntable.
  [[nodiscard]] bool turns_in_place() const noexcept { return turns_in_place_; }
  // The displacement that has the origin at `position` at a time, s, however far the obstacle has turned by then; m.
  [[nodiscard]] Vector3 displacement_to(const Vector3& position, double time) const;
  // Replaces the motion; it turns as before.
  void set_trajectory(Trajectory trajectory) {
    trajectory_ = std::move(trajectory);
    looks_sampled_ = false;
  }
  // Its motion, or turn, is a linear table that looks sampled from a smooth one.
  [[nodiscard]] bool looks_sampled() const noexcept { return looks_sampled_; }
  [[nodiscard]] Pose at(const SampleTime& time) const;
  // The next time after `time` at which its velocity or acceleration may jump; infinity if there is none. s
  [[nodiscard]] double next_change(double time) const {
    return std::min(trajectory_.next_change(time), turning_.next_change(time));
  }

  // Distance of a point, > 0 where nodes may be; m.
  [[nodiscard]] double gap(const Pose& pose, const Vector3& x) const;
  // Its gradient, and that one's derivative (1/m): how the direction turns along the surface.
  [[nodiscard]] Vector3 normal(const Pose& pose, const Vector3& x) const;
  [[nodiscard]] Matrix3 curvature(const Pose& pose, const Vector3& x) const;
  // The part of the gap's second derivative, m/s^2, that is not normal . (a - acceleration_at): of a point that moves
  // with `relative` (m/s) against the surface.
  [[nodiscard]] double bias_acceleration(const Pose& pose, const Vector3& x, const Vector3& relative) const;
  // Below and above 0 by turns on the pieces of a surface between which its curvature jumps, which a step of high order
  // must not cross: the faces, edges and corners of a box, the wall and the ends of a capsule; m. 0 between them,
  // infinity where the surface is of one piece.
  [[nodiscard]] double seam(const Pose& pose, const Vector3& x) const;
  // Onto the surface, along its normal.
  [[nodiscard]] Vector3 onto(const Pose& pose, const Vector3& x) const;
  // How fast it swings from `time` to its next change, rad/s: its place is resolved by times that are apart by far less
  // than the inverse. 0 where next_change() finds all that it does.
  [[nodiscard]] double swing_rate(double time) const noexcept { return trajectory_.swing_rate(time); }
  // The gap of a point that rests is never less than this while the obstacle swings or turns; m.
  [[nodiscard]] double least_gap(const Pose& pose, const Vector3& x) const;
  // Of the greatest ball inside, m; infinity for a plane.
  [[nodiscard]] double inner_radius() const;
  // The share of the way from `a` (where the obstacle was at `before`) to `b` (at `after`), straight as the obstacle
  // sees it, at which a point first touches; empty if it does not. The gap is convex along a line, because the surface
  // bounds a convex body.
  [[nodiscard]] std::optional<double> first_touch(const Pose& before, const Vector3& a, const Pose& after,
                                                  const Vector3& b) const;

 private:
  void follow(const std::optional<Motion>& motion, const std::optional<Turn>& turn);
  [[nodiscard]] bool is_symmetric_about_turn() const;
  // In the obstacle's own frame, where it started.
  [[nodiscard]] double gap(const Vector3& x) const;
  [[nodiscard]] Vector3 normal(const Vector3& x) const;
  [[nodiscard]] Matrix3 curvature(const Vector3& x) const;
  [[nodiscard]] std::optional<double> first_touch(const Vector3& a, const Vector3& b) const;
  // From the nearest point of a capsule's core, the segment between its ends.
  [[nodiscard]] Vector3 from_core(const Vector3& x, bool* between_ends = nullptr) const;
  // Along the axes of a box's core, the box that is left when the rounding is taken off: how far a point is beyond each
  // pair of faces, m; < 0 between them.
  [[nodiscard]] Vector3 beyond_faces(const Vector3& x) const;
  // Out of a box's core, along its axes, length 1: from the nearest point, or through the nearest face.
  [[nodiscard]] Vector3 out_of_core(const Vector3& x, const Vector3& beyond) const;

  enum class Shape { plane, capsule, box };  // a sphere is a capsule

  std::string name_;
  Friction friction_;
  double restitution_;
  Shape shape_;
  Vector3 origin_;
  Vector3 axis_ = Vector3::Zero();      // m: from the first to the second point of a capsule
  Vector3 normal_ = Vector3::UnitZ();   // of a plane
  Matrix3 axes_ = Matrix3::Identity();  // of a box
  Vector3 half_ = Vector3::Zero();      // m: half the size of a box's core
  double radius_ = 0.0;                 // m: of a capsule, of a box's edges
  Trajectory trajectory_;
  Turning turning_;
  bool looks_sampled_ = false;
  bool turns_in_place_ = false;
  Vector3 turn_axis_ = Vector3::UnitZ();
  Vector3 pivot_;  // m: a point of the axis, at the start
};

// How far behind the surface, m, a node at `x` would start, where it may not: 0 where it may, as far as the rounding of
// coordinates tells.
// `size` is that of the body or the scene, m.
[[nodiscard]] double starting_depth(const Obstacle& obstacle, const Pose& pose, const Vector3& x, double size);
// The greatest coordinate of nodes and obstacles of a network, m.
[[nodiscard]] double size_of(const Network& network);
// What is wrong with a node (user's number) that starts `depth` (m) behind a plane or inside an instrument, which is
// described as `surface`.
[[nodiscard]] std::string misplaced(NodeIndex node, double depth, bool plane, const std::string& surface);

}  // namespace springnet
