#include "monitor.hpp"

#include <algorithm>
#include <cmath>

namespace springnet::recurrent {

Verdict Monitor::judge(double difference) noexcept {
  ++sweeps_;
  if (!std::isfinite(difference)) return Verdict::diverging;
  if (sweeps_ > 1) {
    if (difference <= tolerance_) return Verdict::settled;
    window_smallest_ = std::min(window_smallest_, difference);
    least_ = std::min(least_, difference);
    if (difference > growth_limit * least_) return Verdict::diverging;
    if ((sweeps_ - 1) % window == 0) {
      const Verdict verdict = judge_window();
      if (verdict != Verdict::go_on) return verdict;
    }
  }
  return sweeps_ >= max_sweeps_ ? Verdict::out_of_sweeps : Verdict::go_on;
}

Verdict Monitor::judge_window() noexcept {
  // The first window is compared with infinity, so it counts as falling.
  growing_ = window_smallest_ > window_growth * last_window_ ? growing_ + 1 : 0;
  stalled_ = window_smallest_ > noticeable * smallest_ ? stalled_ + 1 : 0;
  smallest_ = std::min(smallest_, window_smallest_);
  last_window_ = window_smallest_;
  window_smallest_ = std::numeric_limits<double>::infinity();
  if (growing_ >= patience) return Verdict::diverging;
  // A window that grew counts as stalled too: while it grows, growth decides.
  if (stalled_ >= patience && growing_ == 0) return Verdict::oscillating;
  return Verdict::go_on;
}

}  // namespace springnet::recurrent
