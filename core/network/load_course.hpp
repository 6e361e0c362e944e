// The factor of a load at any time, and its mean over a step.
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
  // Both disregard the load's window.
  [[nodiscard]] double at(double time) const;
  // Over [from, until], exact but for rounding; s.
  [[nodiscard]] double mean(double from, double until) const;
  // The next time after `time` at which the factor or one of its derivatives jumps; infinity if there is none. s
  [[nodiscard]] double next_kink(double time) const;
  // Bound of the factor's magnitude.
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

// The forces of a load on nodes, N, with the factor 1 and every face where the load was added: a node may come more
// than once.
[[nodiscard]] std::vector<std::pair<NodeIndex, Vector3>> forces_of(const Load& load);
// The same with the pressure on these areas of the faces, m^2.
[[nodiscard]] std::vector<std::pair<NodeIndex, Vector3>> forces_of(const Load& load,
                                                                   const std::vector<Vector3>& pressed_areas);

}  // namespace springnet
