// Why a step did not settle, and what to do, in a sentence for the user.
#pragma once

#include <string>

#include "monitor.hpp"
#include "rule.hpp"

namespace springnet::recurrent {

struct Attempt {
  Verdict verdict = Verdict::diverging;
  Update update = Update::automatic;  // the rule it was made with
  std::string law_message;            // of a law or neuron that had no finite answer
};

[[nodiscard]] std::string explain(const Step& step, const Attempt& attempt, bool chosen_by_user, bool exact_sweeps);

// First node, in the user's numbers, whose output is not finite; no_node if there is none.
[[nodiscard]] std::uint32_t non_finite_node(const Step& step);

}  // namespace springnet::recurrent
