// Eigenvalues of dense matrices. Compiled once for all tests: Eigen's solver takes some seconds to compile.
#pragma once

#include <Eigen/Core>

namespace springnet::testing {

// Of a square matrix, in no order.
[[nodiscard]] Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& matrix);

// The greatest magnitude among them.
[[nodiscard]] double spectral_radius(const Eigen::MatrixXd& matrix);

// The greatest of a symmetric matrix, of which the lower triangle is read.
[[nodiscard]] double greatest_eigenvalue(const Eigen::MatrixXd& symmetric);

}  // namespace springnet::testing
