#include "learning/lanczos.hpp"

#include <algorithm>
#include <vector>

#include "learning/svd.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rounding_of_basis = 1e-13;  // of the greatest value: what is left of a vector that the basis contains

// Takes away what the basis contains, twice: after one pass, rounding of large parts is left.
void orthogonalise(const std::vector<VectorXd>& basis, VectorXd& vector) {
  for (int pass = 0; pass < 2; ++pass)
    for (const VectorXd& each : basis) vector -= each.dot(vector) * each;
}

// Beyond so many products a decomposition takes as long as they do.
constexpr Index products_with_each = 60, products_between = 10;

// A unit vector that the basis does not contain; no size: it contains all.
VectorXd unit_vector_beyond(const std::vector<VectorXd>& basis, Index size) {
  if (static_cast<Index>(basis.size()) >= size) return {};
  VectorXd vector = arbitrary_vector(size, basis.size());
  orthogonalise(basis, vector);
  return vector.normalized();
}

// U^T A = B V^T + above e v^T, with the last vector v behind those of V.
void find_reached(const std::vector<VectorXd>& right, const MatrixXd& b, double above, SingularValues& result) {
  const Index count = b.rows();
  MatrixXd whole = MatrixXd::Zero(count, static_cast<Index>(right.size()));
  whole.leftCols(count) = b;
  if (whole.cols() > count) whole(count - 1, count) = above;
  const Svd svd = right_svd(whole);
  result.reached = svd.values;
  result.reached_right = MatrixXd::Zero(right.front().size(), result.reached.size());
  for (std::size_t k = 0; k < right.size(); ++k)
    result.reached_right += right[k] * svd.right.row(static_cast<Index>(k));
}

}  // namespace

VectorXd arbitrary_vector(Index size, std::uint64_t seed) {
  std::uint64_t state = seed * 0x9e3779b97f4a7c15u + 1;
  VectorXd result(size);
  for (double& each : result) {  // SplitMix64 (Steele, Lea, Flood, OOPSLA 2014)
    std::uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    each = static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1.0;
  }
  return result;
}

SingularValues greatest_singular_values(const Product& times, const Product& transposed_times, Index columns,
                                        const LanczosOptions& options) {
  // A V = U B with the upper bidiagonal B of `diagonal` and `above`, and A^T U = V B^T + (what is left) e^T.
  std::vector<VectorXd> right{unit_vector_beyond({}, columns)}, left;
  std::vector<double> diagonal, above;
  SingularValues result;
  double greatest = 0.0;
  while (true) {
    VectorXd u = times(right.back());
    if (!left.empty()) u -= above.back() * left.back();
    orthogonalise(left, u);
    diagonal.push_back(u.norm());
    greatest = std::max(greatest, diagonal.back());
    const bool is_new = diagonal.back() > rounding_of_basis * greatest;
    VectorXd next = VectorXd::Zero(columns);
    if (is_new) {
      u /= diagonal.back();
      next = transposed_times(u) - diagonal.back() * right.back();
      orthogonalise(right, next);
    } else {
      diagonal.back() = 0.0;
      u.setZero();
    }
    left.push_back(u);
    above.push_back(next.norm());

    const auto count = static_cast<Index>(diagonal.size());
    const bool ends = above.back() <= rounding_of_basis * greatest;  // the basis has all that acts on its vectors
    const bool is_last = count >= options.most_products || count >= columns;
    if (!ends && !is_last && count > products_with_each && count % products_between != 0) {
      right.push_back(next / next.norm());
      continue;
    }
    MatrixXd b = MatrixXd::Zero(count, count);
    for (Index k = 0; k < count; ++k) {
      b(k, k) = diagonal[static_cast<std::size_t>(k)];
      if (k + 1 < count) b(k, k + 1) = above[static_cast<std::size_t>(k)];
    }
    const Svd svd = full_svd(b);
    greatest = std::max(greatest, svd.values[0]);
    result.all = ends && count >= columns;
    Index settled = 0;
    while (settled < count &&
           (ends || above.back() * std::abs(svd.left(count - 1, settled)) <= options.tolerance * greatest))
      ++settled;
    if (result.all || is_last || settled >= options.wanted) {
      settled = std::min(settled, options.wanted);
      while (settled > 0 && !(svd.values[settled - 1] > rounding_of_basis * greatest)) --settled;
      result.values = svd.values.head(settled);
      result.right = MatrixXd::Zero(columns, settled);
      for (Index k = 0; k < count; ++k)
        result.right += right[static_cast<std::size_t>(k)] * svd.right.row(k).head(settled);
      if (!ends) right.push_back(next / next.norm());
      find_reached(right, b, ends ? 0.0 : above.back(), result);
      return result;
    }
    if (ends) above.back() = 0.0;
    right.push_back(ends ? unit_vector_beyond(right, columns) : VectorXd(next / next.norm()));
  }
}

}  // namespace springnet::learning
