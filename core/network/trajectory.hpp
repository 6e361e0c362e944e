// Displacement, velocity and acceleration of a motion at any time.
#pragma once

#include <vector>

#include <springnet/network.hpp>

#include "text/archive.hpp"

namespace springnet {

class Trajectory {
 public:
  Trajectory() = default;  // at rest
  // The motion must be one that Network accepts.
  explicit Trajectory(const Motion& motion);

  struct Sample {
    Vector3 displacement = Vector3::Zero();  // m
    Vector3 velocity = Vector3::Zero();      // m/s
    Vector3 acceleration = Vector3::Zero();  // m/s^2
  };
  // State at a time, s. Where velocity or acceleration jump: their right limits.
  [[nodiscard]] Sample at(double time) const;
  // Mean displacement of a table over [from, until] (s), m, exact up to rounding.
  [[nodiscard]] Vector3 mean(double from, double until) const;
  // The next time after `time` at which velocity or acceleration may jump, s; infinity if there is none.
  [[nodiscard]] double next_change(double time) const;
  // Angular frequency of a sinusoid at a time, rad/s, and its amplitude, m; 0 for other motions.
  [[nodiscard]] double angular_frequency(double time) const noexcept;
  [[nodiscard]] const Vector3& amplitude() const noexcept { return motion_.amplitude; }
  // Greatest speed of a sinusoid, greatest mean speed between two entries of a table, m/s.
  [[nodiscard]] double typical_speed() const noexcept;
  [[nodiscard]] const Motion& motion() const noexcept { return motion_; }
  // The motion.
  void archive(Archive& archive);
  // False if the displacement is 0 at all times.
  [[nodiscard]] bool moves() const noexcept { return moves_; }

 private:
  void find_slopes();
  struct Cubic {
    Vector3 start, linear, square, cube;  // y = start + s (linear + s (square + s cube)), s from 0 to 1
  };
  [[nodiscard]] Cubic piece(std::size_t first) const;  // of a table, from entry `first` to the next
  [[nodiscard]] Sample on_table(double time) const;
  [[nodiscard]] Sample on_sinusoid(double time) const;

  Motion motion_;
  std::vector<Vector3> slopes_;  // m/s, at the entries of a smooth table
  bool moves_ = false;
};

}  // namespace springnet
