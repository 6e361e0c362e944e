#include "layers/linear/coarse_space.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "layers/block.hpp"

namespace springnet::layers {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Nodes of a group at least, and groups at most: a system of 384 numbers, which fits into caches.
constexpr std::size_t least_of_group = 24, most_halvings = 6;
// (Measured: a lattice of 4096 nodes takes as long with and without groups there, a cloud of points far less.)
constexpr std::size_t least_nodes = 300;
constexpr double least_stiffness = 400.0;
// Of a diagonal: groups in a line do not turn about it, and single precision must tell.
constexpr double added = 1e-5;
// Share of a spring's stiffness from which on what it has across its direction counts.
constexpr double least_across = 0.01;

}  // namespace

bool CoarseSpace::pays(std::size_t nodes, double stiffness) noexcept {
  return nodes >= least_nodes && stiffness >= least_stiffness;
}

void CoarseSpace::begin(const std::array<const double*, 3>& position, const std::vector<std::uint8_t>& constrained) {
  is_ready_ = false;
  const std::size_t n = constrained.size();
  group_.assign(n, none);
  place_.assign(n, none);
  node_.clear();
  for (std::uint32_t k = 0; k < n; ++k)
    if (constrained[k] == 0) node_.push_back(k);
  start_.assign({0, static_cast<std::uint32_t>(node_.size())});
  for (std::size_t halving = 0; halving < most_halvings; ++halving) {
    if (node_.size() >> (halving + 1) < least_of_group) break;
    std::vector<std::uint32_t> finer{0};
    for (std::size_t g = 0; g + 1 < start_.size(); ++g) {
      const auto begin = node_.begin() + start_[g], end = node_.begin() + start_[g + 1];
      std::size_t longest = 0;
      double side = -1.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto less = [&](std::uint32_t a, std::uint32_t b) { return position[axis][a] < position[axis][b]; };
        const auto [least, most] = std::minmax_element(begin, end, less);
        const double own = position[axis][*most] - position[axis][*least];
        if (own > side) {
          side = own;
          longest = axis;
        }
      }
      const double* const x = position[longest];
      const auto middle = begin + (end - begin) / 2;
      std::nth_element(begin, middle, end,
                       [x](std::uint32_t a, std::uint32_t b) { return x[a] < x[b] || (x[a] == x[b] && a < b); });
      // Which nodes a half has does not depend on the library; their order, and so sums, would.
      std::sort(begin, middle);
      std::sort(middle, end);
      finer.push_back(static_cast<std::uint32_t>(middle - node_.begin()));
      finer.push_back(start_[g + 1]);
    }
    start_ = std::move(finer);
  }
  arm_.resize(3 * node_.size());
  for (std::uint32_t g = 0; g + 1 < start_.size(); ++g) {
    const auto at = [&](std::uint32_t i) {
      return Vector3d(position[0][node_[i]], position[1][node_[i]], position[2][node_[i]]);
    };
    const double count = start_[g + 1] - start_[g];
    Vector3d centre = Vector3d::Zero();
    for (std::uint32_t i = start_[g]; i < start_[g + 1]; ++i) centre += at(i) / count;
    double square = 0.0;
    for (std::uint32_t i = start_[g]; i < start_[g + 1]; ++i) square += (at(i) - centre).squaredNorm() / count;
    const double radius = square > 0.0 ? std::sqrt(square) : 1.0;
    for (std::uint32_t i = start_[g]; i < start_[g + 1]; ++i) {
      group_[node_[i]] = g;
      place_[node_[i]] = i;
      const Vector3d own = (at(i) - centre) / radius;
      for (Index c = 0; c < 3; ++c) arm_[3 * std::size_t{i} + static_cast<std::size_t>(c)] = static_cast<float>(own[c]);
    }
  }
  const auto size = static_cast<Index>(6 * (start_.size() - 1));
  matrix_.setZero(size, size);
}

void CoarseSpace::add_block(std::size_t row, std::size_t column, const Matrix3d& block) {
  const std::uint32_t i = group_[row], j = group_[column];
  if (i == none || j == none || i < j) return;
  const Matrix3d turn_i = cross_matrix(arm(row)), turn_j = cross_matrix(arm(column));
  auto to = matrix_.block<6, 6>(6 * Index{i}, 6 * Index{j});
  // A turn w moves a node by w x d, which is -[d] w.
  const Matrix3d turned = block * turn_j;
  to.topLeftCorner<3, 3>() += block;
  to.topRightCorner<3, 3>() -= turned;
  to.bottomLeftCorner<3, 3>() += turn_i * block;
  to.bottomRightCorner<3, 3>() -= turn_i * turned;
}

void CoarseSpace::add_spring(std::size_t first, std::size_t second, double a, const Vector3d& q) {
  std::uint32_t i = group_[first], j = group_[second];
  if (i == none && j == none) return;
  const bool is_within = i == j;
  const auto add = [&](const Vector3d& along) {
    using Six = Eigen::Matrix<double, 6, 1>;
    if (is_within) {
      const Vector3d turn = Vector3d(arm(first) - arm(second)).cross(along);
      matrix_.block<3, 3>(6 * Index{i} + 3, 6 * Index{i} + 3) += turn * turn.transpose();
      return;
    }
    Six by_first, by_second;
    if (i != none) {
      by_first << along, arm(first).cross(along);
      matrix_.block<6, 6>(6 * Index{i}, 6 * Index{i}) += by_first * by_first.transpose();
    }
    if (j != none) {
      by_second << along, arm(second).cross(along);
      matrix_.block<6, 6>(6 * Index{j}, 6 * Index{j}) += by_second * by_second.transpose();
    }
    if (i == none || j == none) return;
    if (i > j)
      matrix_.block<6, 6>(6 * Index{i}, 6 * Index{j}) -= by_first * by_second.transpose();
    else
      matrix_.block<6, 6>(6 * Index{j}, 6 * Index{i}) -= by_second * by_first.transpose();
  };
  add(q);
  if (!(a > least_across * q.squaredNorm())) return;
  for (Index c = 0; c < 3; ++c) add(std::sqrt(a) * Vector3d::Unit(c));
}

void CoarseSpace::factorise() {
  is_ready_ = false;
  const Index size = matrix_.rows();
  if (size == 0) return;
  // In units of its diagonal, which differs by the groups' stiffness.
  const Eigen::VectorXd diagonal = matrix_.diagonal();
  if (!(diagonal.minCoeff() > 0.0) || !diagonal.allFinite()) return;
  const Eigen::VectorXd unit = diagonal.cwiseSqrt().cwiseInverse();
  Eigen::MatrixXf scaled(size, size);
  for (Index c = 0; c < size; ++c)
    for (Index r = c; r < size; ++r) scaled(r, c) = static_cast<float>(unit[r] * matrix_(r, c) * unit[c]);
  scaled.diagonal().array() += static_cast<float>(added);
  scale_ = unit.cast<float>();
  factors_.compute(scaled);
  if (factors_.info() != Eigen::Success || !factors_.matrixLLT().diagonal().allFinite()) return;
  right_.resize(size);
  solution_.resize(size);
  is_ready_ = true;
}

void CoarseSpace::solve() {
  solution_ = scale_.cwiseProduct(right_);
  factors_.solveInPlace(solution_);
  solution_ = solution_.cwiseProduct(scale_);
}

}  // namespace springnet::layers
