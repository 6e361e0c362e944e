// What the data say of the variables at the end of a search, from the singular values of the sensitivities.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace springnet::learning {

class Certainty {
 public:
  // jacobian: of the residuals of the observations, by changes of the variables in units of `scale`. residuals: of the
  // same rows. guess_weight: of the squares of the variables' changes from the guess, in the same units. unseen: see
  // Fit::unseen(). is_held: something else than the guess and the data has held the variables, too.
  Certainty(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals, std::size_t observed,
            double guess_weight = 0.0, double unseen = 0.0, bool is_held = false);

  [[nodiscard]] const std::vector<double>& singular_values() const noexcept { return singular_values_; }
  // Directions without influence on anything that was observed.
  [[nodiscard]] std::size_t undetermined() const noexcept { return undetermined_; }
  // Those below are of a combination of the variables from `first` on, with these weights, in the units of the scale.
  // The share of it that lies in directions with influence, 0 to 1.
  [[nodiscard]] double determined(Eigen::Index first, const Eigen::VectorXd& weights) const;
  // Whether anything that was observed depends on one of the variables.
  [[nodiscard]] bool has_influence(Eigen::Index first, const Eigen::VectorXd& weights) const;
  // The share of it that comes from the guess: 1 less that of (J^T J + w)^-1 J^T J along the combination.
  [[nodiscard]] double from_guess(Eigen::Index first, const Eigen::VectorXd& weights) const;
  // The 95 % confidence interval of a linear model of the data alone, with the variance of the residuals that are left:
  // its middle, from where the search has ended (0 without a guess), and half its width; infinite where a part is not
  // determined, or nothing is left to estimate the variance from.
  [[nodiscard]] double middle(Eigen::Index first, const Eigen::VectorXd& weights) const;
  [[nodiscard]] double half_width(Eigen::Index first, const Eigen::VectorXd& weights) const;
  // A change of the variables without what has no influence on anything that was observed, in the units of the scale.
  [[nodiscard]] Eigen::VectorXd with_influence(const Eigen::VectorXd& change) const;
  // The change of the variables that a change of the residuals means, in directions with influence, with the guess.
  [[nodiscard]] Eigen::VectorXd change_for(const Eigen::VectorXd& residuals) const;

 private:
  std::vector<double> singular_values_;
  std::size_t undetermined_ = 0;
  Eigen::MatrixXd inverse_;     // of the sensitivities: the pseudo-inverse, damped by the guess
  Eigen::MatrixXd directions_;  // with influence: [variable][direction]
  Eigen::VectorXd kept_;        // what the guess leaves to the data of each
  Eigen::VectorXd middle_;
  Eigen::VectorXd widths_;  // half those of the intervals along them; no size: nothing to estimate the variance from
  Eigen::Array<bool, Eigen::Dynamic, 1> has_influence_;
};

}  // namespace springnet::learning
