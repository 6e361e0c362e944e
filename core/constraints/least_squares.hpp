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

[[nodiscard]] Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& matrix);

}  // namespace springnet
