#include "network/load_course.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <springnet/sdk/math.hpp>

namespace springnet {

LoadCourse::LoadCourse(const Load& load) : start_(std::isfinite(load.from) ? load.from : 0.0) {
  const Course& course = load.course;
  if (!course.factors.empty()) {
    kind_ = Kind::table;
    Motion motion;
    motion.interpolation = course.interpolation;
    motion.times = course.times;
    greatest_ = 0.0;
    for (const double factor : course.factors) {
      motion.displacements.emplace_back(factor, 0.0, 0.0);
      greatest_ = std::max(greatest_, std::abs(factor));  // the monotone cubic does not overshoot between entries
    }
    table_ = Trajectory(motion);
  } else if (course.frequency > 0.0) {
    kind_ = Kind::sinusoid;
    mean_ = course.mean;
    amplitude_ = course.amplitude;
    phase_ = course.phase;
    rate_ = 2.0 * std::numbers::pi * course.frequency;
    greatest_ = std::abs(mean_) + std::abs(amplitude_);
  } else if (course.ramp > 0.0) {
    kind_ = Kind::ramp;
    ramp_ = course.ramp;
  }
}

double LoadCourse::at(double time) const {
  switch (kind_) {
    case Kind::table:
      return table_.at(time).displacement[0];
    case Kind::sinusoid:
      return mean_ + amplitude_ * sdk::sin(rate_ * (time - start_) + phase_);
    case Kind::ramp:
      return std::clamp((time - start_) / ramp_, 0.0, 1.0);
    default:
      return 1.0;
  }
}

double LoadCourse::mean(double from, double until) const {
  switch (kind_) {
    case Kind::table:
      return table_.mean(from, until)[0];
    case Kind::sinusoid: {
      // The difference of two cosines over the angle between them, without cancellation.
      const double half = 0.5 * rate_ * (until - from);
      const double middle = sdk::sin(rate_ * (0.5 * (from + until) - start_) + phase_);
      return mean_ + amplitude_ * middle * (half > 0.0 ? sdk::sin(half) / half : 1.0);
    }
    case Kind::ramp: {
      const double begin = std::clamp(from, start_, start_ + ramp_), end = std::clamp(until, start_, start_ + ramp_);
      const double held = std::max(0.0, until - std::max(from, start_ + ramp_));
      const double length = until - from;
      return length > 0.0 ? ((end - begin) * 0.5 * (at(begin) + at(end)) + held) / length : at(from);
    }
    default:
      return 1.0;
  }
}

double LoadCourse::next_kink(double time) const {
  if (kind_ == Kind::table) return table_.next_change(time);
  if (kind_ == Kind::ramp) {
    if (time < start_) return start_;
    if (time < start_ + ramp_) return start_ + ramp_;
  }
  return std::numeric_limits<double>::infinity();
}

std::vector<std::pair<NodeIndex, Vector3>> forces_of(const Load& load) { return forces_of(load, load.areas); }

std::vector<std::pair<NodeIndex, Vector3>> forces_of(const Load& load, const std::vector<Vector3>& pressed_areas) {
  std::vector<std::pair<NodeIndex, Vector3>> forces;
  forces.reserve(load.nodes.size() + 3 * load.faces.size());
  for (const NodeIndex node : load.nodes) forces.emplace_back(node, load.force);
  for (std::size_t f = 0; f < load.faces.size(); ++f) {
    const Vector3 third = (load.areas[f].norm() * load.traction - load.pressure * pressed_areas[f]) / 3.0;
    for (const NodeIndex node : load.faces[f]) forces.emplace_back(node, third);
  }
  return forces;
}

}  // namespace springnet
