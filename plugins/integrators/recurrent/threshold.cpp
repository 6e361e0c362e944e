#include "threshold.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace springnet::recurrent {
namespace {

constexpr double automatic_tolerance = 1e-6;  // times the network's force scale
// Share of the typical force above which rounding may hide what matters, and its allowed growth over a step then.
constexpr double noticeable = 0.01, stiffening = 4.0;

}  // namespace

void Threshold::begin(Step& step, bool estimates) {
  if (!exact_sweeps_ && estimates && ++steps_since_estimate_ > steps_per_estimate) {
    steps_since_estimate_ = 0;
    rounding_.estimate(step, step.start);
  }
  set(step);
}

void Threshold::set(Step& step) {
  const double requested = requested_ > 0.0 ? requested_ : automatic_tolerance * step.network.force_scale;
  step.rounding = rounding_.force();
  step.tolerance = std::max(requested, step.rounding);
  if (requested < step.rounding && !exact_sweeps_) note(requested, step);
}

void Threshold::note(double requested, const Step& step) {
  host_.report("force_rounding", step.rounding);
  if (noted_) return;
  noted_ = true;
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(),
                "force_tolerance, %.3g N%s, is below the rounding error of the forces, about %.2g N (stiffness times "
                "the rounding of positions, greatest at node %u): steps settle to the rounding error instead",
                requested, requested_ > 0.0 ? "" : " (1e-6 of the force scale)", step.rounding,
                step.network.user_number[rounding_.node()]);
  host_.note(text.data(), "force_tolerance below rounding");
}

bool Threshold::is_rounding(Step& step) {
  rounding_.estimate(step, *step.outputs);
  steps_since_estimate_ = 0;
  // Far from a solution, outputs may stretch a law until its stiffness hides any force. So noticeable rounding counts
  // only if it is as great at the start of the step.
  if (const double at_outputs = rounding_.force(); at_outputs > noticeable * step.network.force_scale) {
    rounding_.estimate(step, step.start);
    if (at_outputs > stiffening * rounding_.force()) return false;
    rounding_.estimate(step, *step.outputs);
  }
  if (!(step.differences.greatest <= rounding_.force())) return false;
  set(step);
  return true;
}

}  // namespace springnet::recurrent
