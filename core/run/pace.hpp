// Keeping pace with a clock.
#pragma once

#include <functional>

#include <springnet/run.hpp>

namespace springnet {

// The given clock, or the system's if it is empty.
[[nodiscard]] RunClock clock_or_system(const RunClock& clock);

class Pace {
 public:
  // `begin`: simulated time at which the first wait() starts the clock, s. Throws Error(input) for a factor that is not
  // a number above 0.
  Pace(double factor, double begin, RunClock clock);

  // Waits until the clock reaches the start of the time step that begins at `time`. Calls `go_on` ten times a second,
  // and returns false as soon as that does.
  bool wait(double time, const std::function<bool()>& go_on);
  // Call it after the time step that ends at `time`.
  void count_frame(double time);
  [[nodiscard]] const PaceReport& report() const noexcept { return report_; }

 private:
  [[nodiscard]] double clock_time(double time) const { return start_ + (time - begin_) / report_.factor; }

  double begin_;  // s, simulated
  RunClock clock_;
  double start_ = 0.0;  // s, of the clock
  bool started_ = false;
  PaceReport report_;
};

}  // namespace springnet
