#include "inspection/dominant.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Eigenvalues>

namespace springnet {

namespace {

// Krylov space of the map: basis V, projection H = V^T map V, what leaves the space `next`.
struct Krylov {
  Eigen::MatrixXd basis, projection;
  Eigen::Index size = 0;
  double next = 0.0;

  Krylov(const std::function<void(Eigen::VectorXd&)>& map, const Eigen::VectorXd& start, Eigen::Index limit)
      : basis(start.size(), limit), projection(Eigen::MatrixXd::Zero(limit, limit)) {
    Eigen::VectorXd w = start / start.norm();
    double scale = 0.0;  // of the map
    for (size = 0; size < limit;) {
      basis.col(size) = w;
      map(w);
      scale = std::max(scale, w.norm());
      ++size;
      const auto spanned = basis.leftCols(size);
      for (int pass = 0; pass < 2; ++pass) {  // twice is enough (Kahan; Parlett, The Symmetric Eigenvalue Problem)
        const Eigen::VectorXd part = spanned.transpose() * w;
        w.noalias() -= spanned * part;
        projection.col(size - 1).head(size) += part;
      }
      next = w.norm();
      if (!(next > 1e-12 * scale) || !std::isfinite(next)) break;  // what is left is rounding: the space is closed
      if (size < limit) projection(size, size - 1) = next;
      w /= next;
    }
  }
};

bool better(Wanted wanted, const std::complex<double>& a, const std::complex<double>& b) {
  return wanted == Wanted::largest_real ? a.real() > b.real() : std::norm(a) > std::norm(b);
}

}  // namespace

Eigen::VectorXd scattered_vector(Eigen::Index size) {
  Eigen::VectorXd x(size);
  std::uint64_t state = 0x9e3779b97f4a7c15u;
  for (Eigen::Index k = 0; k < size; ++k) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    x[k] = static_cast<double>(state >> 11) * 0x1p-53 - 0.5;
  }
  return size == 0 ? x : Eigen::VectorXd(x / x.norm());
}

Dominant dominant_eigenvalue(const std::function<void(Eigen::VectorXd&)>& map, Eigen::VectorXd& start,
                             const DominantOptions& options) {
  Dominant result;
  if (start.size() == 0) return result;
  const auto limit = std::min(start.size(), static_cast<Eigen::Index>(options.basis));
  std::complex<double> last(std::nan(""), 0.0);
  do {
    const Krylov krylov(map, start, limit);
    result.applications += static_cast<std::size_t>(krylov.size);
    const Eigen::MatrixXd projection = krylov.projection.topLeftCorner(krylov.size, krylov.size);
    if (!projection.allFinite()) {
      result.value = std::numeric_limits<double>::infinity();
      return result;
    }
    const Eigen::EigenSolver<Eigen::MatrixXd> ritz(projection);
    Eigen::Index best = 0;
    for (Eigen::Index k = 1; k < krylov.size; ++k) {
      if (better(options.wanted, ritz.eigenvalues()[k], ritz.eigenvalues()[best])) best = k;
    }
    const Eigen::VectorXcd inside = ritz.eigenvectors().col(best).normalized();
    result.value = ritz.eigenvalues()[best];
    result.error = krylov.next * std::abs(inside[krylov.size - 1]);
    result.real = krylov.basis.leftCols(krylov.size) * inside.real();
    result.imaginary = krylov.basis.leftCols(krylov.size) * inside.imag();
    start = result.real + result.imaginary;
    const double scale = options.tolerance * std::abs(result.value);
    const bool still = std::abs(std::abs(result.value) - std::abs(last)) <= 0.1 * scale;
    if (result.error <= scale || still || krylov.size < limit || limit == start.size()) break;
    last = result.value;
  } while (result.applications + static_cast<std::size_t>(limit) <= options.applications);
  return result;
}

}  // namespace springnet
