// Least-squares solutions of small dense systems. Eigen's complete orthogonal decomposition takes several seconds to
// compile for each type of matrix, so it is compiled here once.
#pragma once

#include <optional>

#include <Eigen/Core>

namespace springnet {

// Of all x that minimise |matrix x - right_hand_side|, the one of least norm. threshold: pivots smaller than this share
// of the greatest count as zero; without it Eigen's default, the rounding of the type times the size.
[[nodiscard]] Eigen::VectorXd least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right_hand_side,
                                            std::optional<double> threshold = {});

// The same for several right-hand sides, a column each.
[[nodiscard]] Eigen::MatrixXd least_squares_of_all(const Eigen::MatrixXd& matrix,
                                                   const Eigen::MatrixXd& right_hand_sides, double threshold);
// Of one, with what of x the equations determine and what they do not, both orthonormal: the rows of the matrix are
// combinations of the columns of `row_space`, and the columns of `kernel`, which is empty where the matrix has full
// rank, are what it maps to zero.
struct Solution {
  Eigen::VectorXd x;
  Eigen::MatrixXd row_space, kernel;
};
[[nodiscard]] Solution solve_least_squares(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right_hand_side,
                                           double threshold);

[[nodiscard]] Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix);

}  // namespace springnet
