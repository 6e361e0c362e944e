// Whether what is left of the differences looks like noise, as intervals take it to be.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <springnet/learn.hpp>

namespace springnet::learning {

// residuals: of the observations of all experiments, as Fit::residuals(), at the values of the result, whose costs and
// rms are known. Sets its `fit`. advice: what else may help, as the end of a sentence.
void judge_fit(const std::vector<Experiment>& experiments, const Eigen::VectorXd& residuals, const std::string& advice,
               LearnedNet& result);

}  // namespace springnet::learning
