// What the data say of the variables at the end of a search, from the singular values of the sensitivities.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace springnet::learning {

class Certainty {
 public:
  // jacobian: of the residuals of the observations, by changes of the variables in units of `scale`. residuals: of the
  // same rows.
  Certainty(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals, std::size_t observed);

  [[nodiscard]] const std::vector<double>& singular_values() const noexcept { return singular_values_; }
  // Directions without influence on anything that was observed.
  [[nodiscard]] std::size_t undetermined() const noexcept { return undetermined_; }
  // Of a combination of the variables from `first` on, with these weights, in the units of the scale: the share of it
  // that lies in directions with influence, 0 to 1.
  [[nodiscard]] double determined(Eigen::Index first, const Eigen::VectorXd& weights) const;
  // Half the width of its 95 % confidence interval, of a linear model with the variance of the residuals that are left;
  // infinite where a part is not determined, or nothing is left to estimate the variance from.
  [[nodiscard]] double half_width(Eigen::Index first, const Eigen::VectorXd& weights) const;
  // The change of the variables that a change of the residuals means, in directions with influence.
  [[nodiscard]] Eigen::VectorXd change_for(const Eigen::VectorXd& residuals) const;

 private:
  std::vector<double> singular_values_;
  std::size_t undetermined_ = 0;
  Eigen::MatrixXd inverse_;     // pseudo-inverse
  Eigen::MatrixXd directions_;  // with influence: [variable][direction]
  Eigen::VectorXd widths_;  // half those of the intervals along them; no size: nothing to estimate the variance from
};

}  // namespace springnet::learning
