#include "material/tensor_fit.hpp"

#include <algorithm>
#include <array>

#include <Eigen/Cholesky>

namespace springnet::material {
namespace {

using Gram = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_springs, max_springs>;

// Tikhonov regularisation. Parallel springs, and directions that span the same tensors, leave the shares undetermined;
// this term on the diagonal selects the smallest, distributed evenly. The relative error of the tensor is about as
// large.
constexpr double regularisation = 1e-10;

double fourth_power(double x) { return (x * x) * (x * x); }

Gram gram_of(std::span<const Vector3> directions) {
  const auto count = static_cast<Eigen::Index>(directions.size());
  Gram gram(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double product = directions[static_cast<std::size_t>(i)].dot(directions[static_cast<std::size_t>(j)]);
      gram(i, j) = gram(j, i) = fourth_power(product);
    }
  }
  return gram;
}

using Marks = std::array<bool, max_springs>;
constexpr int patience = 3;  // rounds without progress

std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

// Shares with zero gradient for the marked springs, 0 for the others.
Shares solve_for(const Gram& gram, const Marks& has_share) {
  std::array<Eigen::Index, max_springs> places{};
  Eigen::Index free = 0;
  for (Eigen::Index i = 0; i < gram.rows(); ++i) {
    if (has_share[at(i)]) places[at(free++)] = i;
  }
  Gram part(free, free);
  for (Eigen::Index i = 0; i < free; ++i) {
    for (Eigen::Index j = 0; j < free; ++j) part(i, j) = gram(places[at(i)], places[at(j)]);
  }
  const Shares solution = part.llt().solve(Shares::Ones(free));
  Shares shares = Shares::Zero(gram.rows());
  for (Eigen::Index i = 0; i < free; ++i) shares[places[at(i)]] = solution[i];
  return shares;
}

}  // namespace

Shares shares_of(std::span<const Vector3> directions) {
  Gram gram = gram_of(directions);
  gram.diagonal().array() += regularisation;
  const Eigen::Index count = gram.rows();

  // Block principal pivoting between springs with and without a share: exchange all infeasible ones as long as their
  // number falls, allowing a few rounds without progress; else only the last one (Murty's rule), which terminates.
  Marks has_share{};
  std::fill_n(has_share.begin(), count, true);
  Shares shares(count);
  std::ptrdiff_t fewest = count + 1;
  int rounds_left = patience;
  for (;;) {
    shares = solve_for(gram, has_share);
    const Shares gradient = gram * shares - Shares::Ones(count);
    constexpr double rounding = 1e-12;
    Marks wrong{};
    for (Eigen::Index i = 0; i < count; ++i) {
      wrong[at(i)] = (has_share[at(i)] ? shares[i] : gradient[i]) < -rounding;
    }
    const std::ptrdiff_t wrong_count = std::count(wrong.begin(), wrong.end(), true);
    if (wrong_count == 0) break;
    if (wrong_count < fewest) {
      fewest = wrong_count;
      rounds_left = patience;
    } else if (--rounds_left < 0) {
      const auto last = std::find(wrong.rbegin(), wrong.rend(), true);
      std::fill(last + 1, wrong.rend(), false);
    }
    for (std::size_t i = 0; i < wrong.size(); ++i) has_share[i] = has_share[i] != wrong[i];
  }
  shares = shares.cwiseMax(0.0);
  return shares / shares.sum();
}

double squared_misfit(std::span<const Vector3> directions, const Shares& shares, int dimension) {
  // In units of lambda: trace C_iijj = d (d + 2), C : n n n n = 3, |C|^2 = 3 d (d + 2).
  const double trace = dimension * (dimension + 2.0);
  const Shares weights = trace * shares;
  const double squared_norm = 3.0 * trace;
  const double square = weights.dot(gram_of(directions) * weights) - 2.0 * 3.0 * weights.sum() + squared_norm;
  return std::max(0.0, square / squared_norm);
}

}  // namespace springnet::material
