// The local propagation of a step: sweeps of one rule until it is clear how the step ends.
#pragma once

#include <cstdint>

#include "monitor.hpp"
#include "rule.hpp"

namespace springnet::recurrent {

struct Limits {
  std::uint64_t max_sweeps;
  std::uint64_t exact_sweeps;  // 0: until settled
};

// Exactly so many sweeps as were asked for (Verdict::go_on) settle a step by definition.
[[nodiscard]] inline bool settled(Verdict verdict) noexcept {
  return verdict == Verdict::settled || verdict == Verdict::go_on;
}

// Whether the equation of motion is fulfilled as well as a settled step's has to be; needs Workspace::complete().
[[nodiscard]] bool within_tolerance(const Step& step) noexcept;

// A step has settled when the forces have, and the outputs obey the equation of motion: a slow rule changes little long
// before they do. The residual is only looked at when the forces have settled, and then less and less often.
[[nodiscard]] Verdict propagate(Rule& rule, Workspace& workspace, Step& step, const Limits& limits);

}  // namespace springnet::recurrent
