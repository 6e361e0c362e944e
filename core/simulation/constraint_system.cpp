#include "simulation/constraint_system.hpp"

#include <algorithm>
#include <utility>

namespace springnet {
namespace {

// Up to this many rows a full matrix is the quicker one.
constexpr std::size_t most_rows_dense = 32;
// Added to the diagonal, in units of its mean, so that redundant rows have a factorisation; iteration takes its effect
// out again.
constexpr double shift_share = 1e-9;

}  // namespace

void ConstraintSystem::set(std::vector<ConstraintRow> rows, const Mobility& mobility) {
  rows_ = std::move(rows);
  const std::size_t count = rows_.size();
  mobilities_.resize(2 * count);
  // By node, the rows that have it, with their sign.
  struct End {
    std::uint32_t node;
    std::uint32_t row;
    double sign;
  };
  std::vector<End> ends;
  ends.reserve(2 * count);
  for (std::uint32_t r = 0; r < count; ++r) {
    mobilities_[2 * r] = mobility(rows_[r].first);
    ends.push_back({rows_[r].first, r, 1.0});
    if (rows_[r].second == ConstraintRow::no_node) continue;
    mobilities_[2 * r + 1] = mobility(rows_[r].second);
    ends.push_back({rows_[r].second, r, -1.0});
  }
  std::stable_sort(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.node < b.node; });

  const auto size = static_cast<Eigen::Index>(count);
  const bool dense = count <= most_rows_dense;
  std::vector<Eigen::Triplet<double>> entries;
  double trace = 0.0;
  if (dense) dense_matrix_.setZero(size, size);
  for (std::size_t begin = 0; begin < ends.size();) {
    std::size_t end = begin;
    while (end < ends.size() && ends[end].node == ends[begin].node) ++end;
    const Eigen::Matrix3d& w = mobilities_[2 * ends[begin].row + (ends[begin].sign < 0.0 ? 1 : 0)];
    for (std::size_t i = begin; i < end; ++i) {
      const Vector3 moved = w * rows_[ends[i].row].direction * ends[i].sign;
      for (std::size_t j = begin; j < end; ++j) {
        const double value = ends[j].sign * rows_[ends[j].row].direction.dot(moved);
        const auto row = static_cast<Eigen::Index>(ends[j].row), column = static_cast<Eigen::Index>(ends[i].row);
        if (row == column) trace += value;
        if (dense)
          dense_matrix_(row, column) += value;
        else
          entries.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
      }
    }
    begin = end;
  }
  if (count == 0) return;
  shift_ = trace > 0.0 ? shift_share * trace / static_cast<double>(count) : 1.0;
  if (dense) {
    Eigen::MatrixXd shifted = dense_matrix_;
    shifted.diagonal().array() += shift_;
    dense_.compute(shifted);
  } else {
    for (Eigen::Index r = 0; r < size; ++r) entries.emplace_back(static_cast<int>(r), static_cast<int>(r), 0.0);
    matrix_.resize(size, size);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    sparse_.setShift(shift_);
    sparse_.compute(matrix_);
  }
}

Eigen::VectorXd ConstraintSystem::solve_shifted(const Eigen::VectorXd& b) const {
  return rows_.size() <= most_rows_dense ? Eigen::VectorXd(dense_.solve(b)) : Eigen::VectorXd(sparse_.solve(b));
}

Eigen::VectorXd ConstraintSystem::solve(const Eigen::VectorXd& b) const {
  if (rows_.empty()) return b;
  const bool dense = rows_.size() <= most_rows_dense;
  const double greatest = b.lpNorm<Eigen::Infinity>();
  Eigen::VectorXd x = solve_shifted(b);
  if (!(greatest > 0.0)) return x;
  // x += (S + shift)^-1 (b - S x): what the shift left out of x shrinks each time by shift / (eigenvalue + shift).
  constexpr int most_corrections = 10;
  double last = greatest;
  for (int i = 0; i < most_corrections; ++i) {
    const Eigen::VectorXd rest = dense ? Eigen::VectorXd(b - dense_matrix_ * x) : Eigen::VectorXd(b - matrix_ * x);
    const double size = rest.lpNorm<Eigen::Infinity>();
    // What does not shrink any more is rounding, or a right side that does not fit: x would only grow.
    if (size <= 1e-15 * greatest || !(size < 0.5 * last)) break;
    last = size;
    x += solve_shifted(rest);
  }
  return x;
}

}  // namespace springnet
