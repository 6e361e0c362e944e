// Greatest singular values of a matrix that is known by its products alone: Golub and Kahan's bidiagonalisation (SIAM
// J. Numer. Anal. B 2, 1965) with full reorthogonalisation, so that no value appears twice by rounding.
#pragma once

#include <cstdint>
#include <functional>

#include <Eigen/Core>

namespace springnet::learning {

struct SingularValues {
  Eigen::VectorXd values;  // the greatest, descending, as far as they have settled
  Eigen::MatrixXd right;   // their right singular vectors, a column each
  bool all = false;        // what is missing is 0
  // A = U U^T A + the rest, with all vectors U that the products have made: singular values of U^T A, and their right
  // vectors. A^T (A A^T + w I)^-1 A is at least what it is for these.
  Eigen::VectorXd reached;
  Eigen::MatrixXd reached_right;
};

struct LanczosOptions {
  Eigen::Index most_products = 100;  // with the matrix, and as many with its transpose
  Eigen::Index wanted = 50;
  double tolerance = 1e-6;  // residual of a pair of vectors, relative to the greatest value
};

using Product = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

// Of several equal values those that the products tell apart: one, unless the values end first. The same bits each
// time.
[[nodiscard]] SingularValues greatest_singular_values(const Product& times, const Product& transposed_times,
                                                      Eigen::Index columns, const LanczosOptions& options = {});

// Numbers from -1 to 1, the same on every platform.
[[nodiscard]] Eigen::VectorXd arbitrary_vector(Eigen::Index size, std::uint64_t seed);

}  // namespace springnet::learning
