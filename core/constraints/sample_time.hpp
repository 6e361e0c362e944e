// Sampling of motions within a step: velocity and acceleration are left limits at its end, right limits at its start.
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
// Earlier by far less than a step of `length` seconds, but a different number.
[[nodiscard]] inline SampleTime just_before(double time, double length) noexcept {
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * std::abs(time);
  return {time, time - std::max(rounding, 1e-12 * length)};
}

// The present step: left limits at its end, right limits elsewhere.
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
