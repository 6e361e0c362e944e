// Angle, rate and angular acceleration of a rotation at any time.
#pragma once

#include <cmath>
#include <limits>

#include <springnet/network.hpp>

#include "network/trajectory.hpp"

namespace springnet {

class Turning {
 public:
  Turning() = default;  // no rotation
  // The turn must be one that Network accepts.
  explicit Turning(const Turn& turn);

  struct Sample {
    double angle = 0.0;         // rad
    double rate = 0.0;          // rad/s
    double acceleration = 0.0;  // rad/s^2
  };
  // State at a time, s. Where rate or acceleration jump: their right limits.
  [[nodiscard]] Sample at(double time) const;
  // The next time after `time` at which they may jump, s; infinity if there is none.
  [[nodiscard]] double next_change(double time) const;
  // The rate, or the greatest mean rate between two entries of a table, rad/s.
  [[nodiscard]] double typical_rate() const noexcept { return rate_ != 0.0 ? std::abs(rate_) : table_.typical_speed(); }
  // False if the angle is 0 at all times.
  [[nodiscard]] bool turns() const noexcept { return rate_ != 0.0 || table_.moves(); }

 private:
  Trajectory table_;    // its x is the angle
  double rate_ = 0.0;   // rad/s; 0: a table
  double from_ = 0.0;   // s
  double until_ = 0.0;  // s
};

}  // namespace springnet
