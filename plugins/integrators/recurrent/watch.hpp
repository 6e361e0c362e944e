// Watches the time of a step that has a deadline: when no further sweep fits, which outputs were the best, and how far
// they are from those of the settled step. Without a deadline it does nothing.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/host.hpp>

#include "step.hpp"

namespace springnet::recurrent {

class Watch {
 public:
  explicit Watch(sdk::Host host) noexcept : host_(host) {}

  // Where sweeps begin, at the newest outputs.
  void begin(const Step& step);
  void after_sweep(const Step& step);
  // Whether another sweep like the last one would end after the deadline.
  [[nodiscard]] bool is_over() const noexcept { return active_ && left_ <= duration_; }
  // Puts the best outputs back if they are not the newest. With surfaces or rigid connections the newest stay: the
  // host's decisions about contacts belong to them.
  void take_best(Step& step) const;
  // Estimate of the greatest error of a position that is left, m, for outputs that complete() has seen; nan without a
  // deadline. See "A step with a deadline" in propagation.md.
  [[nodiscard]] double position_error(const Step& step) const;

 private:
  // Keeps the newest outputs as the best.
  void keep(const Step& step);

  sdk::Host host_;
  bool active_ = false;
  double left_ = 0.0, duration_ = 0.0;  // s: until the deadline, at the end of the last sweep; of that sweep
  double best_ = 0.0;                   // smallest measure, N
  bool newest_is_best_ = true;
  double change_ = 0.0, last_change_ = 0.0;            // m: greatest, by the last sweep and the one before
  std::vector<double> position_;                       // [3n] before the last sweep
  std::vector<double> best_position_, best_velocity_;  // [3n]
};

}  // namespace springnet::recurrent
