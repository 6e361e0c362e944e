// The threshold below which differences of forces count as settled: the requested tolerance, or the rounding error of
// the forces if that is greater.
#pragma once

#include <cstdint>

#include <springnet/sdk/host.hpp>

#include "force_rounding.hpp"
#include "step.hpp"

namespace springnet::recurrent {

class Threshold {
 public:
  // requested: N, 0: 1e-6 of the force scale. exact_sweeps: a step ends after a given number of sweeps, whatever the
  // forces.
  Threshold(sdk::Host host, double requested, bool exact_sweeps)
      : host_(host), rounding_(host), requested_(requested), exact_sweeps_(exact_sweeps) {}

  // Sets tolerance and rounding of a step that begins. estimates: the rule needs derivatives anyway, so the
  // rounding is estimated at the first step and again every steps_per_estimate steps.
  void begin(Step& step, bool estimates);
  // Forgets the estimate: the next step makes its own.
  void forget() noexcept {
    rounding_.forget();
    steps_since_estimate_ = steps_per_estimate;
  }
  // For outputs at which a step has stalled: whether their differences are rounding; if so, it becomes the threshold.
  [[nodiscard]] bool is_rounding(Step& step);

 private:
  void set(Step& step);
  void note(double requested, const Step& step);

  sdk::Host host_;
  ForceRounding rounding_;
  double requested_;  // N
  bool exact_sweeps_;
  bool noted_ = false;  // spares the text: the host keeps one on a topic
  // The rounding changes as laws stiffen and bodies travel.
  static constexpr std::uint64_t steps_per_estimate = 256;
  std::uint64_t steps_since_estimate_ = steps_per_estimate;  // the first step estimates
};

}  // namespace springnet::recurrent
