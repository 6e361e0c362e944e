// Obstacles, which nodes cannot penetrate: planes, spheres, capsules and boxes. Each may move and turn; queries take
// its pose at the time in question.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Core>

#include <springnet/network.hpp>

#include "constraints/sample_time.hpp"
#include "network/trajectory.hpp"
#include "network/turning.hpp"
#include "text/archive.hpp"

namespace springnet {

using Matrix3 = Eigen::Matrix3d;

// Position and motion of a rigid obstacle: its point at x at the start is now at pivot + displacement + rotation (x -
// pivot).
struct Pose {
  Vector3 displacement = Vector3::Zero();  // m, of the pivot
  Vector3 velocity = Vector3::Zero();      // m/s, of the pivot
  Vector3 acceleration = Vector3::Zero();  // m/s^2, of the pivot
  bool turns = false;                      // else the members below are not read
  Vector3 pivot = Vector3::Zero();         // m, at the start
  Matrix3 rotation = Matrix3::Identity();
  Vector3 spin = Vector3::Zero();               // rad/s
  Vector3 spin_acceleration = Vector3::Zero();  // rad/s^2

  // Maps a point of the obstacle from its position now to that at the start, and back; m.
  [[nodiscard]] Vector3 to_start(const Vector3& x) const;
  [[nodiscard]] Vector3 from_start(const Vector3& x) const;
  // Velocity and acceleration of the point of the obstacle that is at `x` now; m/s, m/s^2.
  [[nodiscard]] Vector3 velocity_at(const Vector3& x) const;
  [[nodiscard]] Vector3 acceleration_at(const Vector3& x) const;
};

class Obstacle {
 public:
  explicit Obstacle(const Plane& plane);
  explicit Obstacle(const Instrument& instrument);

  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  // "plane 'floor' (number 0)", "instrument 2"; `number` counts obstacles of its kind.
  [[nodiscard]] std::string description(std::size_t number) const;
  [[nodiscard]] bool is_plane() const noexcept { return shape_ == Shape::plane; }
  // Its normal has the same direction everywhere.
  [[nodiscard]] bool is_flat() const noexcept { return is_plane(); }
  [[nodiscard]] const Friction& friction() const noexcept { return friction_; }
  void set_friction_coefficient(double coefficient) noexcept { friction_.coefficient = coefficient; }
  // Coefficient of restitution, 0 to 1.
  [[nodiscard]] double restitution() const noexcept { return restitution_; }
  // A plane's point, an instrument's first point or a box's centre, at the start; m.
  [[nodiscard]] const Vector3& origin() const noexcept { return origin_; }
  [[nodiscard]] bool moves() const noexcept { return trajectory_.moves() || turns(); }
  [[nodiscard]] bool turns() const noexcept { return turning_.turns(); }
  // It turns about its axis of symmetry, so that its shape stays in place: a drill, a turntable.
  [[nodiscard]] bool turns_in_place() const noexcept { return turns_in_place_; }
  // Of its motion, with a turn at the distance `length` (m) from the axis, unless that leaves its shape in place; m/s.
  [[nodiscard]] double typical_speed(double length) const noexcept {
    return trajectory_.typical_speed() + (turns_in_place_ ? 0.0 : length * turning_.typical_rate());
  }
  // The displacement, m, that puts the origin at `position` at `time`, s, with the rotation at that time.
  [[nodiscard]] Vector3 displacement_to(const Vector3& position, double time) const;
  // Replaces the motion; it turns as before.
  void set_trajectory(Trajectory trajectory) {
    if (!told_) of_scene_ = {std::move(trajectory_), looks_sampled_};
    trajectory_ = std::move(trajectory);
    looks_sampled_ = false;
    told_ = true;
  }
  // The motion and the friction set since the start.
  void archive(Archive& archive) {
    archive.number(friction_.coefficient);
    if (!(friction_.coefficient >= 0.0 && std::isfinite(friction_.coefficient)))
      Archive::refuse("a coefficient of friction is below 0 or not finite");
    bool told = told_;
    archive.flag(told);
    if (told) {
      Trajectory trajectory = trajectory_;
      trajectory.archive(archive);
      if (archive.reads()) set_trajectory(std::move(trajectory));
    } else if (told_) {
      trajectory_ = of_scene_.trajectory;
      looks_sampled_ = of_scene_.looks_sampled;
      told_ = false;
    }
  }
  [[nodiscard]] const Trajectory& trajectory() const noexcept { return trajectory_; }
  // Its motion was set since the start, by the embedding program.
  [[nodiscard]] bool told() const noexcept { return told_; }
  // Its motion or turn is a linear table that looks sampled from a smooth function.
  [[nodiscard]] bool looks_sampled() const noexcept { return looks_sampled_; }
  [[nodiscard]] Pose at(const SampleTime& time) const;
  // The next time after `time` at which its velocity or acceleration may jump, s; infinity if there is none.
  [[nodiscard]] double next_change(double time) const {
    return std::min(trajectory_.next_change(time), turning_.next_change(time));
  }
  [[nodiscard]] double next_change_of_turn(double time) const { return turning_.next_change(time); }

  // Signed distance of a point, m; > 0 outside.
  [[nodiscard]] double gap(const Pose& pose, const Vector3& x) const;
  // Gradient of the gap (unit), and its Hessian (1/m).
  [[nodiscard]] Vector3 normal(const Pose& pose, const Vector3& x) const;
  [[nodiscard]] Matrix3 curvature(const Pose& pose, const Vector3& x) const;
  // Bias term of the gap acceleration, m/s^2: d^2 gap/dt^2 = normal . (a - acceleration_at) + bias, for a point with
  // velocity `relative` (m/s) to the surface. Curvature term v_rel' H v_rel and, if it turns, the Coriolis term.
  [[nodiscard]] double bias_acceleration(const Pose& pose, const Vector3& x, const Vector3& relative) const;
  // A function (m) that changes its sign where the curvature jumps, which a step of high order must not cross: between
  // faces, edges and corners of a box, between wall and ends of a capsule. Infinity if the surface is one smooth piece.
  [[nodiscard]] double seam(const Pose& pose, const Vector3& x) const;
  // Projection onto the surface along its normal.
  [[nodiscard]] Vector3 onto(const Pose& pose, const Vector3& x) const;
  // Distance at which a ray, whose direction has the length 1, first crosses the surface, m, from outside or from
  // inside; empty if it does not.
  [[nodiscard]] std::optional<double> meets(const Pose& pose, const Vector3& from, const Vector3& direction) const;
  // Angular frequency of its oscillation from `time` to its next change, rad/s; sampling times must be much closer than
  // its inverse. 0 if next_change() finds all changes.
  [[nodiscard]] double angular_frequency(double time) const noexcept { return trajectory_.angular_frequency(time); }
  // Lower bound of the gap of a resting point while the obstacle oscillates or turns; m.
  [[nodiscard]] double min_gap(const Pose& pose, const Vector3& x) const;
  // Radius of the largest inscribed ball, m; infinity for a plane.
  [[nodiscard]] double inscribed_radius() const;
  // The share of the path from `a` (obstacle at `before`) to `b` (at `after`), straight in the obstacle's frame, at
  // which a point first touches; empty if it does not. The gap is convex along a line because the body is convex.
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
  // Vector to x from the nearest point of a capsule's core, the segment between its ends.
  [[nodiscard]] Vector3 from_core(const Vector3& x, bool* between_ends = nullptr) const;
  // How far a point is beyond each pair of faces of a box's core (the box less its rounding), along its axes, m; < 0
  // between them.
  [[nodiscard]] Vector3 beyond_faces(const Vector3& x) const;
  // Unit vector out of a box's core, along its axes: from the nearest point of the core, or inside through the nearest
  // face.
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
  bool looks_sampled_ = false, told_ = false;
  struct {
    Trajectory trajectory;
    bool looks_sampled = false;
  } of_scene_;  // if told_
  bool turns_in_place_ = false;
  Vector3 turn_axis_ = Vector3::UnitZ();
  Vector3 pivot_;  // m: a point of the axis, at the start
};

// Depth, m, at which a node at `x` would start behind the surface; 0 if it is outside up to the rounding of
// coordinates. `size`: of the body or the scene, m.
[[nodiscard]] double starting_depth(const Obstacle& obstacle, const Pose& pose, const Vector3& x, double size);
// The greatest absolute coordinate of nodes and obstacles of a network, m.
[[nodiscard]] double size_of(const Network& network);
// Error message for a node (user's number) that starts `depth` (m) behind a plane or inside an instrument; `surface`
// describes it.
[[nodiscard]] std::string misplaced(NodeIndex node, double depth, bool plane, const std::string& surface);

}  // namespace springnet
