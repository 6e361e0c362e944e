#include "eigenvalues.hpp"

#include <Eigen/Eigenvalues>

namespace springnet::testing {

Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& matrix) { return matrix.eigenvalues(); }

double spectral_radius(const Eigen::MatrixXd& matrix) { return eigenvalues(matrix).cwiseAbs().maxCoeff(); }

double greatest_eigenvalue(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

}  // namespace springnet::testing
