#include "constraints/constraint_system.hpp"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

namespace springnet {
namespace {

// Up to this many rows a dense matrix is faster.
constexpr std::size_t max_rows_dense = 32;
// Shift of the diagonal, in units of its mean, so that redundant rows can be factorised; iterative refinement removes
// its effect.
constexpr double shift_share = 1e-9;
// Relative residual above which conjugate gradients follow the refinement: some eigenvalue is not large compared with
// the shift.
constexpr double residual_share = 1e-12;

}  // namespace

struct ConstraintSystem::Matrices {
  Eigen::SparseMatrix<double> sparse;  // of form rows G W G^T, of form nodes G W^(1/2)
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> sparse_factors;
  Eigen::MatrixXd dense;
  Eigen::LDLT<Eigen::MatrixXd> dense_factors;
};

ConstraintSystem::ConstraintSystem() : matrices_(std::make_unique<Matrices>()) {}
ConstraintSystem::~ConstraintSystem() = default;
ConstraintSystem::ConstraintSystem(ConstraintSystem&&) noexcept = default;
ConstraintSystem& ConstraintSystem::operator=(ConstraintSystem&&) noexcept = default;

void ConstraintSystem::set(std::vector<ConstraintRow> rows, const Mobility& mobility) {
  rows_ = std::move(rows);
  const bool any_pairs = std::any_of(rows_.begin(), rows_.end(), [](const ConstraintRow& row) { return row.is_pair; });
  ends_ = any_pairs ? ConstraintRow::most_ends : 2;
  mobilities_.resize(ends_ * rows_.size());
  double trace = 0.0;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const Vector3& direction = rows_[r].direction;
    rows_[r].for_each_end([&](std::size_t i, std::uint32_t node, double weight) {
      Eigen::Matrix3d& own = mobilities_[ends_ * r + i];
      own = mobility(node);
      trace += weight * weight * direction.dot(own * direction);
    });
  }
  if (rows_.empty()) return;
  shift_ = trace > 0.0 ? shift_share * trace / static_cast<double>(rows_.size()) : 1.0;
  form_ = rows_.size() <= max_rows_dense ? Form::dense : Form::rows;
  if (form_ == Form::rows && set_nodes())
    form_ = Form::nodes;
  else
    set_rows();
}

// Assembles G W G^T over rows.
void ConstraintSystem::set_rows() {
  const std::size_t count = rows_.size();
  // The ends of all rows, sorted by node.
  struct End {
    std::uint32_t node;
    std::uint32_t row, place;
    double weight;
  };
  std::vector<End> ends;
  ends.reserve(ends_ * count);
  for (std::uint32_t r = 0; r < count; ++r)
    rows_[r].for_each_end([&](std::size_t i, std::uint32_t node, double weight) {
      ends.push_back({node, r, static_cast<std::uint32_t>(i), weight});
    });
  std::stable_sort(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.node < b.node; });

  const auto size = static_cast<Eigen::Index>(count);
  std::vector<Eigen::Triplet<double>> entries;
  if (form_ == Form::dense) matrices_->dense.setZero(size, size);
  for (std::size_t begin = 0; begin < ends.size();) {
    std::size_t end = begin;
    while (end < ends.size() && ends[end].node == ends[begin].node) ++end;
    const Eigen::Matrix3d& w = mobility(ends[begin].row, ends[begin].place);
    for (std::size_t i = begin; i < end; ++i) {
      const Vector3 moved = w * rows_[ends[i].row].direction * ends[i].weight;
      for (std::size_t j = begin; j < end; ++j) {
        const double value = ends[j].weight * rows_[ends[j].row].direction.dot(moved);
        const auto row = static_cast<Eigen::Index>(ends[j].row), column = static_cast<Eigen::Index>(ends[i].row);
        if (form_ == Form::dense)
          matrices_->dense(row, column) += value;
        else
          entries.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
      }
    }
    begin = end;
  }
  if (form_ == Form::dense) {
    Eigen::MatrixXd shifted = matrices_->dense;
    shifted.diagonal().array() += shift_;
    matrices_->dense_factors.compute(shifted);
  } else {
    for (Eigen::Index r = 0; r < size; ++r) entries.emplace_back(static_cast<int>(r), static_cast<int>(r), 0.0);
    matrices_->sparse.resize(size, size);
    matrices_->sparse.setFromTriplets(entries.begin(), entries.end());
    matrices_->sparse_factors.setShift(shift_);
    matrices_->sparse_factors.compute(matrices_->sparse);
  }
}

// Assembles the matrix over nodes, K = A^T A + shift with A = G W^(1/2), which solves for rows by
//   (A A^T + shift)^-1 = (1 - A K^-1 A^T) / shift.
// False if it would not be smaller than the one over rows, or a mobility has no square root.
bool ConstraintSystem::set_nodes() {
  std::unordered_map<std::uint32_t, std::pair<int, Eigen::Matrix3d>> nodes;  // first column and root of the mobility
  int columns = 0;
  const auto add = [&](std::uint32_t node, const Eigen::Matrix3d& mobility) {
    if (mobility.isZero(0.0)) return true;
    const auto [place, is_new] = nodes.try_emplace(node, columns, Eigen::Matrix3d::Zero());
    if (!is_new) return true;
    columns += 3;
    if (!mobility.isApprox(mobility.transpose())) return false;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(mobility);
    if (!(solver.eigenvalues().minCoeff() >= 0.0)) return false;
    place->second.second = solver.operatorSqrt();
    return true;
  };
  bool all = true;
  for (std::size_t r = 0; r < rows_.size() && all; ++r)
    rows_[r].for_each_end(
        [&](std::size_t i, std::uint32_t node, double) { all = all && add(node, this->mobility(r, i)); });
  if (!all) return false;
  if (columns == 0 || static_cast<std::size_t>(columns) > rows_.size()) return false;

  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(3 * ends_ * rows_.size());
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    rows_[r].for_each_end([&](std::size_t, std::uint32_t node, double weight) {
      const auto found = nodes.find(node);
      if (found == nodes.end()) return;
      const auto& [column, root] = found->second;
      const Vector3 row = weight * (root * rows_[r].direction);
      for (int c = 0; c < 3; ++c) entries.emplace_back(static_cast<int>(r), column + c, row[c]);
    });
  }
  matrices_->sparse.resize(static_cast<Eigen::Index>(rows_.size()), columns);
  matrices_->sparse.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SparseMatrix<double> squares = matrices_->sparse.transpose() * matrices_->sparse;
  matrices_->sparse_factors.setShift(shift_);
  matrices_->sparse_factors.compute(squares);
  return true;
}

Eigen::VectorXd ConstraintSystem::product(const Eigen::VectorXd& x) const {
  switch (form_) {
    case Form::dense:
      return matrices_->dense * x;
    case Form::rows:
      return matrices_->sparse * x;
    case Form::nodes:
      break;
  }
  return matrices_->sparse * (matrices_->sparse.transpose() * x).eval();
}

Eigen::VectorXd ConstraintSystem::solve_shifted(const Eigen::VectorXd& b) const {
  switch (form_) {
    case Form::dense:
      return matrices_->dense_factors.solve(b);
    case Form::rows:
      return matrices_->sparse_factors.solve(b);
    case Form::nodes:
      break;
  }
  const Eigen::VectorXd y = matrices_->sparse_factors.solve(matrices_->sparse.transpose() * b);
  return (b - matrices_->sparse * y) / shift_;
}

// Conjugate gradients, preconditioned with the shifted matrix: eigenvalues large compared with the shift become 1, each
// of the few others takes about one iteration. Zero if the right-hand side is not in the range.
Eigen::VectorXd ConstraintSystem::solve_by_conjugate_gradients(const Eigen::VectorXd& b) const {
  constexpr int max_iterations = 40;
  const double greatest = b.lpNorm<Eigen::Infinity>();
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(b.size());
  Eigen::VectorXd x = zero, best = zero, residual = b, z = solve_shifted(residual), direction = z;
  double least = greatest, product_before = residual.dot(z);
  for (int i = 0; i < max_iterations && least > 1e-3 * residual_share * greatest; ++i) {
    const Eigen::VectorXd image = product(direction);
    const double curvature = direction.dot(image);
    // The direction is in the null space: no multipliers reduce the residual along it.
    if (!(curvature > 1e-6 * shift_ * direction.squaredNorm())) break;
    x += product_before / curvature * direction;
    residual = b - product(x);
    const double size = residual.lpNorm<Eigen::Infinity>();
    if (size < least) {
      least = size;
      best = x;
    }
    z = solve_shifted(residual);
    const double product_now = residual.dot(z);
    direction = z + product_now / product_before * direction;
    product_before = product_now;
  }
  return least <= 1e-3 * greatest ? best : zero;
}

Eigen::VectorXd ConstraintSystem::solve(const Eigen::VectorXd& b) const {
  if (rows_.empty()) return b;
  const double greatest = b.lpNorm<Eigen::Infinity>();
  Eigen::VectorXd x = solve_shifted(b);
  if (!(greatest > 0.0)) return x;
  // x += (S + shift)^-1 (b - S x): what the shift left out of x shrinks each time by shift / (eigenvalue + shift).
  constexpr int max_corrections = 10;
  double last = greatest, size = greatest;
  Eigen::VectorXd residual;
  for (int i = 0; i < max_corrections; ++i) {
    residual = b - product(x);
    size = residual.lpNorm<Eigen::Infinity>();
    // A residual that stops shrinking is rounding, or a right-hand side out of range: x would only grow.
    if (size <= 1e-15 * greatest || !(size < 0.5 * last)) break;
    last = size;
    x += solve_shifted(residual);
  }
  // Needed where masses span many decades, for example.
  if (size > residual_share * greatest) x += solve_by_conjugate_gradients(b - product(x));
  return x;
}

Eigen::MatrixXd ConstraintSystem::effective_mobility(const std::vector<std::uint32_t>& nodes,
                                                     const Mobility& mobility) const {
  const auto size = static_cast<Eigen::Index>(3 * nodes.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Eigen::Matrix3d own = mobility(nodes[i]);
    const auto begin = static_cast<Eigen::Index>(3 * i);
    for (Eigen::Index c = 0; c < 3; ++c) {
      const auto velocity = [&](std::uint32_t node) {
        return node == nodes[i] ? Vector3(own.col(c)) : Vector3(Vector3::Zero());
      };
      result.block<3, 1>(begin, begin + c) += own.col(c);
      for_each_change(solve(-rates(velocity)), [&](std::uint32_t changed, const Vector3& change) {
        const auto place = std::find(nodes.begin(), nodes.end(), changed) - nodes.begin();
        if (place < static_cast<std::ptrdiff_t>(nodes.size())) result.block<3, 1>(3 * place, begin + c) += change;
      });
    }
  }
  return result;
}

}  // namespace springnet
