// Motions within a step: at its end velocity and acceleration are those just before, at its start those just after.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "network/trajectory.hpp"
#include "network/turning.hpp"

namespace springnet {

struct SampleTime {
  double time;  // s: of the displacement
  double rate;  // s: of velocity and acceleration
  friend bool operator==(const SampleTime&, const SampleTime&) = default;
};

[[nodiscard]] inline SampleTime just_after(double time) noexcept { return {time, time}; }
// Far less before than a step of `length` seconds takes, and still another number.
[[nodiscard]] inline SampleTime just_before(double time, double length) noexcept {
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * std::abs(time);
  return {time, time - std::max(rounding, 1e-12 * length)};
}

// The present step: motions at its end are those just before, elsewhere those just after.
struct Interval {
  double from = 0.0, until = std::numeric_limits<double>::infinity();  // s
  [[nodiscard]] SampleTime at(double time) const noexcept {
    return time >= until && std::isfinite(until) ? just_before(time, until - from) : just_after(time);
  }
};

[[nodiscard]] inline Trajectory::Sample sample(const Trajectory& trajectory, const SampleTime& at) {
  Trajectory::Sample result = trajectory.at(at.rate);
  if (at.rate != at.time) result.displacement = trajectory.at(at.time).displacement;
  return result;
}
[[nodiscard]] inline Turning::Sample sample(const Turning& turning, const SampleTime& at) {
  Turning::Sample result = turning.at(at.rate);
  if (at.rate != at.time) result.angle = turning.at(at.time).angle;
  return result;
}

}  // namespace springnet
