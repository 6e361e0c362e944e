#include "simulation/later.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "network/trajectory.hpp"
#include "network/turning.hpp"

namespace springnet {
namespace {

void shift(std::vector<double>& times, double time) {
  for (double& each : times) each -= time;
}

}  // namespace

std::optional<Motion> later(const Motion& motion, double time) {
  Motion result = motion;
  if (!motion.displacements.empty()) {
    if (motion.times.back() <= time) return std::nullopt;
    const Vector3 now = Trajectory(motion).at(time).displacement;
    shift(result.times, time);
    for (Vector3& each : result.displacements) each -= now;
    return result;
  }
  if (motion.until <= time) return std::nullopt;
  result.until -= time;
  if (motion.from > time) {
    result.from -= time;
    return result;
  }
  // a (sin(w (t + time - from) + phase) - sin(phase)) less its value at t = 0
  result.phase += 2.0 * std::numbers::pi * motion.frequency * (time - motion.from);
  result.from = 0.0;
  return result;
}

std::optional<Turn> later(const Turn& turn, double time) {
  Turn result = turn;
  if (!turn.angles.empty()) {
    if (turn.times.back() <= time) return std::nullopt;
    const double now = Turning(turn).at(time).angle;
    shift(result.times, time);
    for (double& each : result.angles) each -= now;
    return result;
  }
  if (turn.until <= time) return std::nullopt;
  result.until -= time;
  result.from = std::max(0.0, turn.from - time);
  return result;
}

std::optional<Load> later(const Load& load, double time) {
  if (load.until <= time) return std::nullopt;
  Load result = load;
  Course& course = result.course;
  result.until -= time;
  shift(course.times, time);
  if (std::isfinite(load.from)) {  // sinusoids and ramps count from there
    result.from -= time;
    return result;
  }
  if (course.ramp > 0.0) {
    course.interpolation = Motion::Interpolation::linear;
    course.times = {-time, course.ramp - time};
    course.factors = {0.0, 1.0};
    course.ramp = 0.0;
  } else if (course.frequency > 0.0) {
    course.phase += 2.0 * std::numbers::pi * course.frequency * time;
  }
  return result;
}

Signal later(const Signal& signal, double time) {
  Signal result = signal;
  shift(result.times, time);
  result.phase += 2.0 * std::numbers::pi * signal.frequency * time;
  return result;
}

}  // namespace springnet
