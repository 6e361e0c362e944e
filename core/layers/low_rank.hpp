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
  // What A x = b and the terms make of b.
  [[nodiscard]] Eigen::VectorXd solve(bool transposed, const Eigen::VectorXd& right_side, const Solve& solve_a);

 private:
  Eigen::MatrixXd u_, w_;
  // Of A, and of its transpose: A^-1 u, and 1 + w^T A^-1 u in factors.
  bool known_[2] = {false, false};
  Eigen::MatrixXd answers_[2];
  Eigen::FullPivLU<Eigen::MatrixXd> small_[2];
};

}  // namespace springnet::layers
