// The times at which a run makes records.
#pragma once

#include <algorithm>
#include <cmath>

#include <springnet/scene.hpp>

namespace springnet {

// s, between records: no record is made within a time step.
[[nodiscard]] inline double record_interval(const Scene& scene) {
  return std::max(scene.output.interval, scene.options.time_step);
}

// Differences of times below this are rounding, s; Simulation::advance_to() takes them so, too.
[[nodiscard]] inline double time_slack(double time_step, double duration) {
  return 1e-6 * std::min(time_step, duration);
}

// The first multiple of the interval after `time`.
[[nodiscard]] inline double next_multiple(double interval, double time, double slack) {
  return interval * (std::floor((time + slack) / interval) + 1.0);
}

// One at the start, one each interval, and one at the end if that falls between.
[[nodiscard]] inline double count_records(double duration, double interval) {
  const double intervals = duration / interval;
  const double whole = std::floor(intervals * (1.0 + 1e-12));
  return whole + 1.0 + (intervals - whole > 1e-9 * intervals ? 1.0 : 0.0);
}

}  // namespace springnet
