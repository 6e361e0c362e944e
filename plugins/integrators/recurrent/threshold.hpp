// The threshold below which differences of forces count as settled: the one that was asked for, or the rounding of the
// forces where that is above.
#pragma once

#include <cstdint>

#include <springnet/sdk/host.hpp>

#include "force_rounding.hpp"
#include "step.hpp"

namespace springnet::recurrent {

class Threshold {
 public:
  // asked: N, 0: 1e-6 of the force scale. exact_sweeps: a step ends after a given number of sweeps, whatever the
  // forces.
  Threshold(sdk::Host host, double asked, bool exact_sweeps)
      : host_(host), rounding_(host), asked_(asked), exact_sweeps_(exact_sweeps) {}

  // Sets tolerance and rounding of a step that begins. estimates: the rule needs derivatives anyway, so that the
  // rounding is estimated at the start, and anew now and then.
  void begin(Step& step, bool estimates);
  // For outputs at which a step has stalled: whether their differences are rounding, which becomes the threshold.
  [[nodiscard]] bool is_rounding(Step& step);

 private:
  void set(Step& step);
  void note(double asked, const Step& step);

  sdk::Host host_;
  ForceRounding rounding_;
  double asked_;  // N
  bool exact_sweeps_;
  bool noted_ = false;
  // Steps between estimates of the rounding: laws stiffen, bodies travel.
  static constexpr std::uint64_t steps_per_estimate = 256;
  std::uint64_t steps_since_estimate_ = steps_per_estimate;  // the first step estimates
};

}  // namespace springnet::recurrent
