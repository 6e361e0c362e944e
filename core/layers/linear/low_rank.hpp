// Systems (A + sum_i u_i w_i^T) x = b with the solutions of A alone (Sherman, Morrison, Woodbury).
#pragma once

#include <functional>

#include <Eigen/Dense>

namespace springnet::layers {

class LowRank {
 public:
  // Solves A x = b, or A^T x = b, for one or more columns.
  using Solve = std::function<Eigen::MatrixXd(bool transposed, const Eigen::MatrixXd& right_side)>;

  // One column a term; no columns: none. Has to be called after every new factorisation of A.
  void set(Eigen::MatrixXd columns, Eigen::MatrixXd weights) {
    u_ = std::move(columns);
    w_ = std::move(weights);
    known_[0] = known_[1] = false;
  }
  [[nodiscard]] bool empty() const noexcept { return u_.cols() == 0; }
  // Product with the sum of the terms, or with its transpose.
  [[nodiscard]] Eigen::VectorXd times(bool transposed, const Eigen::VectorXd& x) const;
  // Whether the whole system has no solution, or none that digits are left of, though A has; no: there may be one.
  [[nodiscard]] bool is_singular(const Solve& solve_a);
  // What A x = b and the terms make of b. Of a singular system: something finite.
  [[nodiscard]] Eigen::VectorXd solve(bool transposed, const Eigen::VectorXd& right_side, const Solve& solve_a);

 private:
  // 1 + w^T A^-1 u in factors. Terms may differ by many orders of magnitude, so each row and each column is brought to
  // the size of 1 first: what is small against another term is no rounding.
  struct Small {
    Eigen::VectorXd row, column;
    Eigen::FullPivLU<Eigen::MatrixXd> factors;
  };
  const Small& small(bool transposed, const Solve& solve_a);

  Eigen::MatrixXd u_, w_;
  // Of A, and of its transpose: A^-1 u, and what is made of it.
  bool known_[2] = {false, false};
  Eigen::MatrixXd answers_[2];
  Small small_[2];
};

}  // namespace springnet::layers
