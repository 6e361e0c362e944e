// What searches of every kind tell at their end, and the parts of observations that they learn from.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <springnet/learn.hpp>

#include "learning/certainty.hpp"
#include "learning/variables.hpp"

namespace springnet::learning {

// Root mean square of weighted residuals; 0 if nothing is observed.
[[nodiscard]] double rms_of(const Eigen::VectorXd& residuals, std::size_t observed);

// What was observed in [from, until], s.
[[nodiscard]] Observations part_of(const Observations& all, double from, double until);

// The parameters of a result, without what is known of them.
[[nodiscard]] std::vector<LearnedParameter> list_parameters(const std::vector<Learnable>& learnables);

// What is known of them at x. certainty: null: nothing; shift: of the variables by half the time step; no size: not
// known.
void describe(LearnedNet& learned, const Variables& variables, const Eigen::VectorXd& x, const Certainty* certainty,
              const Eigen::VectorXd& shift);

}  // namespace springnet::learning
