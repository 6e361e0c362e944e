#include "layers/low_rank.hpp"

namespace springnet::layers {

Eigen::VectorXd LowRank::times(bool transposed, const Eigen::VectorXd& x) const {
  const Eigen::MatrixXd& u = transposed ? w_ : u_;
  const Eigen::MatrixXd& w = transposed ? u_ : w_;
  return u * (w.transpose() * x);
}

Eigen::VectorXd LowRank::solve(bool transposed, const Eigen::VectorXd& right_side, const Solve& solve_a) {
  const Eigen::MatrixXd& u = transposed ? w_ : u_;
  const Eigen::MatrixXd& w = transposed ? u_ : w_;
  const int which = transposed ? 1 : 0;
  if (!known_[which]) {
    answers_[which] = solve_a(transposed, u);
    Eigen::MatrixXd small = w.transpose() * answers_[which];
    small.diagonal().array() += 1.0;
    small_[which].compute(small);
    known_[which] = true;
  }
  const Eigen::VectorXd x = solve_a(transposed, right_side);
  return x - answers_[which] * small_[which].solve(w.transpose() * x);
}

}  // namespace springnet::layers
