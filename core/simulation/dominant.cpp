#include "simulation/dominant.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace springnet {
namespace {

// Sizes of the basis at which convergence is checked, besides the full one.
constexpr std::array<Eigen::Index, 2> early{10, 20};

// Krylov space of the map: basis V, projection H = V^T map V, `next`: norm of the part of the last image outside V.
class Krylov {
 public:
  Krylov(const std::function<void(Eigen::VectorXd&)>& map, const Eigen::VectorXd& start, Eigen::Index limit)
      : map_(map), basis_(start.size(), limit), projection_(Eigen::MatrixXd::Zero(limit, limit)) {
    vector_ = start / start.norm();
  }

  // Up to `wanted` vectors; fewer if the space becomes invariant.
  void grow(Eigen::Index wanted) {
    while (size_ < wanted && !invariant_) {
      basis_.col(size_) = vector_;
      map_(vector_);
      scale_ = std::max(scale_, vector_.norm());
      ++size_;
      const auto spanned = basis_.leftCols(size_);
      for (int pass = 0; pass < 2; ++pass) {  // twice is enough (Kahan; Parlett, The Symmetric Eigenvalue Problem)
        const Eigen::VectorXd part = spanned.transpose() * vector_;
        vector_.noalias() -= spanned * part;
        projection_.col(size_ - 1).head(size_) += part;
      }
      next_ = vector_.norm();
      invariant_ = !(next_ > 1e-12 * scale_) || !std::isfinite(next_);  // the rest is rounding
      if (invariant_) return;
      if (size_ < projection_.rows()) projection_(size_, size_ - 1) = next_;
      vector_ /= next_;
    }
  }
  [[nodiscard]] Eigen::Index size() const { return size_; }
  [[nodiscard]] bool is_invariant() const { return invariant_; }
  [[nodiscard]] double next() const { return next_; }
  [[nodiscard]] auto basis() const { return basis_.leftCols(size_); }
  [[nodiscard]] Eigen::MatrixXd projection() const { return projection_.topLeftCorner(size_, size_); }

 private:
  const std::function<void(Eigen::VectorXd&)>& map_;
  Eigen::MatrixXd basis_, projection_;
  Eigen::VectorXd vector_;
  Eigen::Index size_ = 0;
  double next_ = 0.0, scale_ = 0.0;
  bool invariant_ = false;
};

bool better(Wanted wanted, const std::complex<double>& a, const std::complex<double>& b) {
  return wanted == Wanted::largest_real ? a.real() > b.real() : std::norm(a) > std::norm(b);
}

// The wanted eigenvalue of the projection, and its residual. False if numbers are not finite.
bool find_eigenvalue(const Krylov& krylov, Wanted wanted, Dominant& result, Eigen::VectorXcd& inside) {
  const Eigen::MatrixXd projection = krylov.projection();
  if (!projection.allFinite()) return false;
  const Eigen::EigenSolver<Eigen::MatrixXd> ritz(projection);
  Eigen::Index best = 0;
  for (Eigen::Index k = 1; k < krylov.size(); ++k)
    if (better(wanted, ritz.eigenvalues()[k], ritz.eigenvalues()[best])) best = k;
  inside = ritz.eigenvectors().col(best).normalized();
  result.value = ritz.eigenvalues()[best];
  result.error = krylov.next() * std::abs(inside[krylov.size() - 1]);
  return true;
}

}  // namespace

Dominant dominant_eigenvalue(const std::function<void(Eigen::VectorXd&)>& map, Eigen::VectorXd& start,
                             const DominantOptions& options) {
  Dominant result;
  if (start.size() == 0) return result;
  const auto limit = std::min(start.size(), static_cast<Eigen::Index>(options.basis));
  std::complex<double> last(std::nan(""), 0.0);
  do {
    Krylov krylov(map, start, limit);
    Eigen::VectorXcd inside;
    const auto converged = [&] { return result.error <= options.tolerance * std::abs(result.value); };
    bool finite = true;
    for (std::size_t i = 0; i <= early.size() && finite; ++i) {
      const Eigen::Index wanted = i < early.size() ? early[i] : limit;
      if (wanted >= limit && i < early.size()) continue;
      krylov.grow(wanted);
      finite = find_eigenvalue(krylov, options.wanted, result, inside);
      if (finite && (converged() || krylov.is_invariant())) break;
    }
    result.applications += static_cast<std::size_t>(krylov.size());
    if (!finite) {
      result.value = std::numeric_limits<double>::infinity();
      return result;
    }
    result.real = krylov.basis() * inside.real();
    result.imaginary = krylov.basis() * inside.imag();
    start = result.real + result.imaginary;
    const bool stalled =
        std::abs(std::abs(result.value) - std::abs(last)) <= 0.1 * options.tolerance * std::abs(result.value);
    if (converged() || stalled || krylov.is_invariant() || limit == start.size()) break;
    last = result.value;
  } while (result.applications + static_cast<std::size_t>(limit) <= options.applications);
  return result;
}

}  // namespace springnet
