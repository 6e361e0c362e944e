// Searches from several starts, of which the best is kept.
#pragma once

#include <functional>

#include <Eigen/Core>

#include <springnet/learn.hpp>

#include "learning/fit.hpp"
#include "learning/minimise.hpp"
#include "learning/search.hpp"

namespace springnet::learning {

// Throws Error(input) for numbers of starts and factors that make no sense.
void check_starts(const LearnOptions& options);

// A start at random; see LearnOptions::starts. number: from 1; the same one is always the same.
[[nodiscard]] Eigen::VectorXd random_start(const Variables& variables, const LearnOptions& options, int number);

// Searches from further starts. search_from: a search through all stages; first: what it has found from the first
// start. The history in `result` is that of the best one.
[[nodiscard]] Minimum best_of_starts(Fit& fit, Search& search, Minimum first,
                                     const std::function<Minimum(const Eigen::VectorXd& start)>& search_from,
                                     LearnedNet& result);

// Tells in parameters how far starts differ that are as good as the best, and in a note how many are.
void describe_starts(LearnedNet& result);

}  // namespace springnet::learning
