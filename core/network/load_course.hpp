// The time-dependent factor of a load, and its mean over a step.
#pragma once

#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "network/trajectory.hpp"

namespace springnet {

class LoadCourse {
 public:
  // The load must be one that Network accepts.
  explicit LoadCourse(const Load& load);

  // Whether the factor is 1 at all times.
  [[nodiscard]] bool is_constant() const noexcept { return kind_ == Kind::constant; }
  // Factor at a time, s, disregarding the load's window.
  [[nodiscard]] double at(double time) const;
  // Mean of the factor over [from, until], s, exact up to rounding, disregarding the window.
  [[nodiscard]] double mean(double from, double until) const;
  // The next time after `time` at which the factor or one of its derivatives jumps, s; infinity if there is none.
  [[nodiscard]] double next_kink(double time) const;
  // Upper bound of the factor's magnitude.
  [[nodiscard]] double greatest() const noexcept { return greatest_; }

 private:
  enum class Kind { constant, table, sinusoid, ramp };

  Kind kind_ = Kind::constant;
  Trajectory table_;    // its x
  double start_ = 0.0;  // s
  double mean_ = 0.0, amplitude_ = 0.0, phase_ = 0.0;
  double rate_ = 0.0;  // rad/s
  double ramp_ = 0.0;  // s
  double greatest_ = 1.0;
};

// The forces of a load on nodes, N, at factor 1 and with the face areas of the time when the load was added. A node may
// occur several times.
[[nodiscard]] std::vector<std::pair<NodeIndex, Vector3>> forces_of(const Load& load);
// The same with the pressure acting on these face area vectors, m^2.
[[nodiscard]] std::vector<std::pair<NodeIndex, Vector3>> forces_of(const Load& load,
                                                                   const std::vector<Vector3>& pressed_areas);

}  // namespace springnet
