#include "layers/linear/low_rank.hpp"

namespace springnet::layers {
namespace {

// Relative threshold of pivots; entries are sums of terms up to 1.
constexpr double rounding_of_sums = 1e-14;

}  // namespace

Eigen::VectorXd LowRank::times(bool transposed, const Eigen::VectorXd& x) const {
  const Eigen::MatrixXd& u = transposed ? w_ : u_;
  const Eigen::MatrixXd& w = transposed ? u_ : w_;
  return u * (w.transpose() * x);
}

const LowRank::Small& LowRank::small(bool transposed, const Solve& solve_a) {
  const int which = transposed ? 1 : 0;
  Small& result = small_[which];
  if (known_[which]) return result;
  solutions_[which] = solve_a(transposed, transposed ? w_ : u_);
  Eigen::MatrixXd matrix = (transposed ? u_ : w_).transpose() * solutions_[which];
  const auto one = Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
  Eigen::MatrixXd size = matrix.cwiseAbs() + one;  // size of the terms; their sum may cancel to rounding
  matrix += one;
  result.row = size.rowwise().maxCoeff().cwiseInverse();
  size = result.row.asDiagonal() * size;
  result.column = size.colwise().maxCoeff().transpose().cwiseInverse();
  matrix = result.row.asDiagonal() * matrix * result.column.asDiagonal();
  result.factors.setThreshold(rounding_of_sums);
  result.factors.compute(matrix);
  known_[which] = true;
  return result;
}

bool LowRank::is_singular(const Solve& solve_a) { return !empty() && !small(false, solve_a).factors.isInvertible(); }

Eigen::VectorXd LowRank::solve(bool transposed, const Eigen::VectorXd& right_side, const Solve& solve_a) {
  const Small& s = small(transposed, solve_a);
  const Eigen::MatrixXd& w = transposed ? u_ : w_;
  const Eigen::VectorXd x = solve_a(transposed, right_side);
  const Eigen::VectorXd scaled = s.row.asDiagonal() * (w.transpose() * x);
  return x - solutions_[transposed ? 1 : 0] * (s.column.asDiagonal() * s.factors.solve(scaled));
}

}  // namespace springnet::layers
