// Events within a time step: which of the host's event functions have crossed zero since it began, and when.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/host.hpp>

namespace springnet::recurrent {

class Crossings {
 public:
  // Begins a step at `time` (s) with this state.
  void begin(const sdk::Host& host, double time, const springnet_state& state);
  // Evaluates the events at a later time of the step. Returns whether any has crossed by then.
  [[nodiscard]] bool evaluate(const sdk::Host& host, double time, const springnet_state& state);
  // Narrows the interval of the first crossing by the result of the last evaluate(). Returns the next time to evaluate,
  // inside of the interval.
  [[nodiscard]] double next_time() noexcept;
  // Whether any event crossed at any of the times.
  [[nodiscard]] bool any() const noexcept { return any_; }
  [[nodiscard]] double low() const noexcept { return low_; }    // s, before
  [[nodiscard]] double high() const noexcept { return high_; }  // s, after
  // Whether a contact should have ended, or a slip begun, before the step begins.
  [[nodiscard]] bool is_due() const noexcept { return is_due_; }
  // [event_count], 1: crossed at the last evaluate().
  [[nodiscard]] const std::int32_t* fired() const noexcept { return fired_.data(); }

 private:
  std::vector<double> first_, low_values_, high_values_, values_;
  std::vector<std::int32_t> directions_, fired_, high_fired_;
  std::vector<std::uint32_t> kinds_;
  double low_ = 0.0, high_ = 0.0;
  double low_weight_ = 1.0, high_weight_ = 1.0;  // of the Illinois rule
  int side_ = 0;                                 // end that moved last: -1 low, 1 high
  int evaluations_ = 0;
  bool any_ = false, is_due_ = false;
};

}  // namespace springnet::recurrent
