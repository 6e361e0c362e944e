// Monitors the local propagation of one time step: it settles, or fails in one of three ways.
#pragma once

#include <cstdint>
#include <limits>

#include <springnet/sdk/plugin.h>

namespace springnet::recurrent {

enum class Verdict {
  go_on = -1,
  settled = SPRINGNET_SETTLED,
  oscillating = SPRINGNET_OSCILLATING,
  out_of_sweeps = SPRINGNET_OUT_OF_SWEEPS,
  diverging = SPRINGNET_DIVERGING,
  out_of_time = SPRINGNET_OUT_OF_TIME
};

// Judges the greatest force differences of successive sweeps. Windows of sweeps are compared by their smallest
// difference, so that beats of a converging iteration are not taken for the end of convergence.
class Monitor {
 public:
  static constexpr std::uint64_t window = 50;   // sweeps
  static constexpr double noticeable = 0.99;    // a window below this share of all before counts as falling
  static constexpr double window_growth = 2.0;  // a window that rises by this factor counts as growing
  static constexpr double growth_limit = 1e9;   // beyond this multiple of the smallest difference it diverges
  static constexpr std::uint64_t patience = 2;  // windows in a row that decide

  // tolerance: N, >= 0. max_sweeps: >= 1.
  Monitor(double tolerance, std::uint64_t max_sweeps) noexcept : tolerance_(tolerance), max_sweeps_(max_sweeps) {}

  // Call after each sweep with its greatest force difference (N; if not finite: `diverging`). The first sweep never
  // settles: its outputs replace the activities, so its forces have nothing to be compared with.
  [[nodiscard]] Verdict judge(double difference) noexcept;

  // Call instead after a sweep whose difference means nothing.
  [[nodiscard]] Verdict skip() noexcept {
    forget();
    return ++sweeps_ >= max_sweeps_ ? Verdict::out_of_sweeps : Verdict::go_on;
  }
  // What follows is another problem than what was, with the same number of sweeps left.
  void forget() noexcept {
    least_ = smallest_ = window_smallest_ = last_window_ = std::numeric_limits<double>::infinity();
    growing_ = stalled_ = 0;
  }
  // The next difference may be any number of times those before.
  void expect_jump() noexcept { least_ = std::numeric_limits<double>::infinity(); }

  [[nodiscard]] std::uint64_t sweeps() const noexcept { return sweeps_; }

 private:
  [[nodiscard]] Verdict judge_window() noexcept;

  double tolerance_;
  std::uint64_t max_sweeps_;
  std::uint64_t sweeps_ = 0;
  double least_ = std::numeric_limits<double>::infinity();            // since the last jump
  double smallest_ = std::numeric_limits<double>::infinity();         // of the step so far, without this window
  double window_smallest_ = std::numeric_limits<double>::infinity();  // of this window
  double last_window_ = std::numeric_limits<double>::infinity();      // of the window before
  std::uint64_t growing_ = 0;                                         // windows in a row
  std::uint64_t stalled_ = 0;
};

}  // namespace springnet::recurrent
