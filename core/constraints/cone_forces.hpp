// Forces of redundant contacts. Faces on faces have more pairs than determine forces: of all that keep what touches
// together these are the smallest that press and stay within their friction cones.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace springnet {

// Where some of the unknowns may lie.
struct ForceCone {
  Eigen::Index first = 0;  // of the unknowns: a normal force, N, and with friction two tangential ones after it
  bool has_friction = false;
  double coefficient = 0.0;  // of friction, 1
};

// N; below zero by how far the unknowns lie outside of the cone that is worst.
[[nodiscard]] double margin_in_cones(const Eigen::VectorXd& x, const std::vector<ForceCone>& cones);

// Of all x = base + kernel z the one of least norm that lies in all cones; if none does, of those that lie nearest to
// them, by the sum of squares, the least. base is orthogonal to the kernel, whose columns are orthonormal, as are those
// of row_space, which spans the rest. Unknowns without a cone may have either sign.
[[nodiscard]] Eigen::VectorXd least_in_cones(const Eigen::VectorXd& base, const Eigen::MatrixXd& row_space,
                                             const Eigen::MatrixXd& kernel, const std::vector<ForceCone>& cones);

// Of all x in the cones with the resultants that `start` has, the products with the rows of a sparse matrix, the one of
// least norm; `start`, which lies in the cones but for rounding, where that is not found.
[[nodiscard]] Eigen::VectorXd least_with_resultants(const Eigen::SparseMatrix<double>& resultants,
                                                    const Eigen::VectorXd& start, const std::vector<ForceCone>& cones);

}  // namespace springnet
