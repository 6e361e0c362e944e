// Error message for a step that did not settle: the reason and what to do.
#pragma once

#include <limits>
#include <string>

#include "monitor.hpp"
#include "rule.hpp"

namespace springnet::recurrent {

struct Attempt {
  Verdict verdict = Verdict::diverging;
  Update update = Update::automatic;  // the rule it was made with
  std::string law_message;            // of a law or neuron without a finite result
};

// What the advice depends on.
struct Circumstances {
  bool chosen_by_user = false;  // the update rule
  bool exact_sweeps = false;
  bool accelerated = false;
  bool divided = false;         // smaller and smaller steps were tried
  bool fails_at_start = false;  // a law or neuron has no finite result at the start of the step
  // The start is the result of steps of a fixed number of sweeps, which do not test themselves.
  bool starts_untested = false;
  // theta times the time constant over the critical one of synchronous sweeps; nan: not known.
  double over_critical = std::numeric_limits<double>::quiet_NaN();
};

[[nodiscard]] std::string explain(const Step& step, const Attempt& attempt, const Circumstances& circumstances);

// First node, in the user's numbers, whose output is not finite; no_node if there is none.
[[nodiscard]] std::uint32_t non_finite_node(const Step& step);

}  // namespace springnet::recurrent
