// Local propagation of a step: sweeps of one rule until the outcome of the step is known.
#pragma once

#include <cstdint>

#include "anderson.hpp"
#include "monitor.hpp"
#include "rule.hpp"
#include "watch.hpp"

namespace springnet::recurrent {

struct Limits {
  std::uint64_t max_sweeps;
  std::uint64_t exact_sweeps;  // 0: until settled
};

// With a given number of sweeps (Verdict::go_on) a step counts as settled by definition.
[[nodiscard]] inline bool settled(Verdict verdict) noexcept {
  return verdict == Verdict::settled || verdict == Verdict::go_on;
}

// Whether a step is taken as it is.
[[nodiscard]] inline bool ends(Verdict verdict) noexcept { return settled(verdict) || verdict == Verdict::out_of_time; }

// Whether the residual of the equation of motion is small enough for a settled step; needs Workspace::complete().
[[nodiscard]] bool within_tolerance(const Step& step) noexcept;

// A step has settled when the forces have and the residual of the equation of motion is small: a slow rule changes
// little long before. The residual is evaluated only once the forces have settled, then less and less often. At a
// deadline (Verdict::out_of_time, after one sweep at least) the outputs are the best until then.
// acceleration: combines the outputs of the sweeps, if it is on.
[[nodiscard]] Verdict propagate(Rule& rule, Workspace& workspace, Step& step, const Limits& limits,
                                Anderson& acceleration, Watch& watch);

}  // namespace springnet::recurrent
