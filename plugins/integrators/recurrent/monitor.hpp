// How the local propagation of one time step goes: it settles, or it shows in one of three ways that it will not.
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
  diverging = SPRINGNET_DIVERGING
};

// Judges the greatest force differences of successive sweeps. Windows of sweeps are compared by their smallest
// difference, so that a beat in an iteration that contracts is not mistaken for the end of the contraction.
class Monitor {
 public:
  static constexpr std::uint64_t window = 50;   // sweeps
  static constexpr double noticeable = 0.99;    // a window that falls below this share of all before has fallen
  static constexpr double window_growth = 2.0;  // a window that rises by this factor has grown
  static constexpr double growth_limit = 1e9;   // beyond this multiple of the smallest difference nothing returns
  static constexpr std::uint64_t patience = 2;  // windows in a row that decide

  // tolerance: N, >= 0. max_sweeps: >= 1.
  Monitor(double tolerance, std::uint64_t max_sweeps) noexcept : tolerance_(tolerance), max_sweeps_(max_sweeps) {}

  // After each sweep, with its greatest force difference (N; a non-finite one is `diverging`). The first sweep has
  // nothing that its forces may be compared with: outputs replace activities only in it, so it never settles.
  [[nodiscard]] Verdict judge(double difference) noexcept;

  [[nodiscard]] std::uint64_t sweeps() const noexcept { return sweeps_; }

 private:
  [[nodiscard]] Verdict judge_window() noexcept;

  double tolerance_;
  std::uint64_t max_sweeps_;
  std::uint64_t sweeps_ = 0;
  double smallest_ = std::numeric_limits<double>::infinity();         // of the step so far, this window left out
  double window_smallest_ = std::numeric_limits<double>::infinity();  // of this window
  double last_window_ = std::numeric_limits<double>::infinity();      // of the window before
  std::uint64_t growing_ = 0;                                         // windows in a row
  std::uint64_t stalled_ = 0;
};

}  // namespace springnet::recurrent
