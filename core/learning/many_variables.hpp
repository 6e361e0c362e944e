// What can be said of more variables than sensitivities are known for as a whole.
#pragma once

#include <Eigen/Core>

#include <springnet/learn.hpp>

#include "learning/fit.hpp"
#include "learning/lanczos.hpp"

namespace springnet::learning {

// Of the residuals of the observations, by changes of the variables in units of their scale, where `fit` is linearised.
[[nodiscard]] SingularValues singular_values(Fit& fit, const LanczosOptions& options);

// Sets singular_values, and of the parameters from_guess (at most so much; more products find less) and has_influence:
// at the linearised point.
void describe_many(LearnedNet& learned, Fit& fit, int products);

}  // namespace springnet::learning
