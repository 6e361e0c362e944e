// The dual problem of cone_forces.cpp for many forces: each acts on few resultants, so that its matrices are sparse.

#include <Eigen/SparseCholesky>
#include <algorithm>

#include "constraints/cone_forces.hpp"
#include "constraints/cone_projection.hpp"

namespace springnet {

Eigen::VectorXd least_with_resultants(const Eigen::SparseMatrix<double>& resultants, const Eigen::VectorXd& start,
                                      const std::vector<ForceCone>& cones) {
  constexpr double accuracy = 1e-13, sufficient = 1e-10;  // of resultants, in units of them
  using Matrix = Eigen::SparseMatrix<double>;
  const ConeProjection project(cones);
  const Matrix transposed = resultants.transpose();
  const Eigen::VectorXd d = resultants * start;
  const double size = d.norm();
  if (size == 0.0) return start;
  // The mean of the diagonal of its product with itself.
  const double scale = resultants.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, resultants.rows()));
  Eigen::VectorXd y = Eigen::VectorXd::Zero(d.size()), x = start;
  const auto evaluate = [&](const Eigen::VectorXd& at, Eigen::VectorXd& gradient) {
    x = project.of(transposed * at);
    gradient = resultants * x - d;
    return 0.5 * x.squaredNorm() - d.dot(at);
  };
  Matrix identity(d.size(), d.size());
  identity.setIdentity();
  const auto newton = [&](const Eigen::VectorXd& at, const Eigen::VectorXd& gradient,
                          double weight) -> Eigen::VectorXd {
    const Matrix moved = project.derivative(transposed * at) * transposed;
    const double shift = scale * (1e-12 + 1e-4 * weight * std::min(1.0, gradient.norm() / size));
    const Matrix matrix = resultants * moved + shift * identity;
    const Eigen::SimplicialLDLT<Matrix> factors(matrix);
    return factors.info() == Eigen::Success ? Eigen::VectorXd(factors.solve(gradient))
                                            : Eigen::VectorXd(Eigen::VectorXd::Zero(d.size()));
  };
  minimise(y, evaluate, newton,
           [&](const Eigen::VectorXd&, const Eigen::VectorXd& gradient) { return gradient.norm() <= accuracy * size; });
  Eigen::VectorXd gradient;
  evaluate(y, gradient);
  return gradient.norm() <= sufficient * size && x.norm() <= start.norm() ? x : start;
}

}  // namespace springnet
