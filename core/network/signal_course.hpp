// The value of a signal over time.
#pragma once

#include <springnet/signal.hpp>

#include "network/trajectory.hpp"

namespace springnet {

class SignalCourse {
 public:
  // The signal must be one that Network accepts.
  explicit SignalCourse(const Signal& signal);

  // At a time, s; where it jumps, its right limit.
  [[nodiscard]] double at(double time) const;
  [[nodiscard]] bool is_constant() const noexcept { return kind_ == Kind::constant; }
  // Whether it has jumps.
  [[nodiscard]] bool jumps() const noexcept { return kind_ == Kind::hold; }
  // The next time after `time` at which the value or one of its derivatives jumps, s; infinity if there is none.
  [[nodiscard]] double next_kink(double time) const;

 private:
  enum class Kind { constant, hold, curve, sinusoid };

  Kind kind_ = Kind::constant;
  std::vector<double> times_, values_;  // hold
  Trajectory curve_;                    // its x
  double mean_, amplitude_, rate_, phase_;
};

}  // namespace springnet
