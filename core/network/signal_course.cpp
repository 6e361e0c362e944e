#include "network/signal_course.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include <springnet/sdk/math.hpp>

namespace springnet {

SignalCourse::SignalCourse(const Signal& signal)
    : mean_(signal.mean),
      amplitude_(signal.amplitude),
      rate_(2.0 * std::numbers::pi * signal.frequency),
      phase_(signal.phase) {
  if (!signal.values.empty()) {
    const bool varies = std::any_of(signal.values.begin(), signal.values.end(),
                                    [&](double value) { return value != signal.values.front(); });
    if (!varies) {
      mean_ = signal.values.front();
    } else if (signal.interpolation == Signal::Interpolation::hold) {
      kind_ = Kind::hold;
      times_ = signal.times;
      values_ = signal.values;
    } else {
      kind_ = Kind::curve;
      Motion motion;
      motion.interpolation = signal.interpolation == Signal::Interpolation::linear ? Motion::Interpolation::linear
                                                                                   : Motion::Interpolation::smooth;
      motion.times = signal.times;
      for (const double value : signal.values) motion.displacements.emplace_back(value, 0.0, 0.0);
      curve_ = Trajectory(motion);
    }
  } else if (signal.frequency > 0.0) {
    kind_ = Kind::sinusoid;
  }
}

double SignalCourse::at(double time) const {
  switch (kind_) {
    case Kind::hold: {
      const auto after = std::upper_bound(times_.begin(), times_.end(), time) - times_.begin();
      return values_[static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - 1, 0))];
    }
    case Kind::curve:
      return curve_.at(time).displacement[0];
    case Kind::sinusoid:
      return mean_ + amplitude_ * sdk::sin(rate_ * time + phase_);
    default:
      return mean_;
  }
}

double SignalCourse::next_kink(double time) const {
  if (kind_ == Kind::curve) return curve_.next_change(time);
  if (kind_ == Kind::hold) {
    const auto next = std::upper_bound(times_.begin(), times_.end(), time);
    if (next != times_.end()) return *next;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace springnet
