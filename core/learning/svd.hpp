// Singular value decompositions A = left diag(values) right^T, values in descending order. Eigen's take a minute to
// compile with sanitizers, so they are compiled here once.
#pragma once

#include <Eigen/Core>

namespace springnet::learning {

struct Svd {
  Eigen::VectorXd values;
  Eigen::MatrixXd left, right;
};

// As many vectors as values; by divide and conquer.
[[nodiscard]] Svd thin_svd(const Eigen::MatrixXd& matrix);
// Likewise, but `left` stays empty.
[[nodiscard]] Svd right_svd(const Eigen::MatrixXd& matrix);
// All vectors of both sides; by Jacobi's rotations, which find small values to more digits.
[[nodiscard]] Svd full_svd(const Eigen::MatrixXd& matrix);

}  // namespace springnet::learning
