#include "constraints/least_squares.hpp"

#include <Eigen/QR>

namespace springnet {

Eigen::VectorXd least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right_hand_side,
                              std::optional<double> threshold) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors;
  if (threshold) factors.setThreshold(*threshold);
  return factors.compute(matrix).solve(right_hand_side);
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix) {
  return Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(matrix).pseudoInverse();
}

}  // namespace springnet
