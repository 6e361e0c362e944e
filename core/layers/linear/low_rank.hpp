// Solves (A + sum_i u_i w_i^T) x = b by solutions with A alone (Sherman, Morrison, Woodbury).
#pragma once

#include <functional>

#include <Eigen/Dense>

namespace springnet::layers {

class LowRank {
 public:
  // Solves A x = b, or A^T x = b, for one or more right-hand sides.
  using Solve = std::function<Eigen::MatrixXd(bool transposed, const Eigen::MatrixXd& right_side)>;

  // One column per term; none for no terms. Call it after every new factorisation of A.
  void set(Eigen::MatrixXd columns, Eigen::MatrixXd weights) {
    u_ = std::move(columns);
    w_ = std::move(weights);
    known_[0] = known_[1] = false;
  }
  [[nodiscard]] bool empty() const noexcept { return u_.cols() == 0; }
  // Product of sum_i u_i w_i^T, or its transpose, with x.
  [[nodiscard]] Eigen::VectorXd times(bool transposed, const Eigen::VectorXd& x) const;
  // Whether the whole matrix is singular to working precision although A is not.
  [[nodiscard]] bool is_singular(const Solve& solve_a);
  // Solution of the whole system; something finite if it is singular.
  [[nodiscard]] Eigen::VectorXd solve(bool transposed, const Eigen::VectorXd& right_side, const Solve& solve_a);

 private:
  // Factors of I + w^T A^-1 u. Terms may differ by many orders of magnitude, so rows and columns are scaled to 1 first;
  // otherwise a small term would look like rounding.
  struct Small {
    Eigen::VectorXd row, column;
    Eigen::FullPivLU<Eigen::MatrixXd> factors;
  };
  const Small& small(bool transposed, const Solve& solve_a);

  Eigen::MatrixXd u_, w_;
  // For A and for its transpose: A^-1 u, and the small matrix factorised.
  bool known_[2] = {false, false};
  Eigen::MatrixXd solutions_[2];
  Small small_[2];
};

}  // namespace springnet::layers
