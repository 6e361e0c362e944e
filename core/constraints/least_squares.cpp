#include "constraints/least_squares.hpp"

#include <Eigen/QR>

namespace springnet {

Eigen::VectorXd least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right_hand_side,
                              std::optional<double> threshold) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors;
  if (threshold) factors.setThreshold(*threshold);
  return factors.compute(matrix).solve(right_hand_side);
}

Solution solve_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right_hand_side, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors;
  factors.setThreshold(threshold);
  Solution result;
  result.x = factors.compute(matrix).solve(right_hand_side);
  const Eigen::Index rank = factors.rank(), more = matrix.cols() - rank;
  if (more == 0) return result;
  const Eigen::MatrixXd directions = factors.colsPermutation() * factors.matrixZ().transpose();
  result.row_space = directions.leftCols(rank);
  result.kernel = directions.rightCols(more);
  return result;
}

Eigen::MatrixXd least_squares_of_all(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right_hand_sides,
                                     double threshold) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors;
  factors.setThreshold(threshold);
  return factors.compute(matrix).solve(right_hand_sides);
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix) {
  return Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(matrix).pseudoInverse();
}

}  // namespace springnet
