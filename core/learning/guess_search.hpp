// The last search where a rule finds the weight of the guess: with weights that lead to it.
#pragma once

#include <vector>

#include <springnet/learn.hpp>

#include "learning/fit.hpp"
#include "learning/minimise.hpp"
#include "learning/search.hpp"

namespace springnet::learning {

// All weights are 1: then they are hardly those of standard deviations.
[[nodiscard]] bool have_plain_weights(const std::vector<Experiment>& experiments);

// greatest: the weight to begin with. minimum: what was found from parts of the motion; then what the search has found.
// The fit has the weight of the rule, and the result the curve.
void search_by_rule(Search& search, Fit& fit, double greatest, LearnedNet& result, Minimum& minimum);

}  // namespace springnet::learning
