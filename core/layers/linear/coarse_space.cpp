#include "layers/linear/coarse_space.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "layers/block.hpp"

namespace springnet::layers {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Nodes of a group at least, and groups at most: a system of 384 numbers, which fits into caches.
constexpr std::size_t least_of_group = 24, most_halvings = 6;
// Measured: kept for many systems, they take as long with groups as without at some 40 in lattices of 512 to 32768
// nodes, and a third less at 180. Without diagonals, where groups are not rigid, and in cloth they do not help.
constexpr std::size_t least_nodes = 300;
constexpr double least_stiffness = 400.0, least_stiffness_of_many = 40.0;
// Of a diagonal: groups in a line do not turn about it, and single precision must tell.
constexpr double added = 1e-5;
// Share of a spring's stiffness from which on what it has across its direction counts.
constexpr double least_across = 0.01;

}  // namespace

bool CoarseSpace::pays(std::size_t nodes, double stiffness, bool serves_many) noexcept {
  return nodes >= least_nodes && stiffness >= (serves_many ? least_stiffness_of_many : least_stiffness);
}

void CoarseSpace::begin(const std::array<const double*, 3>& position, const std::vector<std::uint8_t>& constrained) {
  is_ready_ = false;
  const std::size_t n = constrained.size();
  group_.assign(n, none);
  place_.assign(n, none);
  all_nodes_.clear();
  for (std::uint32_t k = 0; k < n; ++k)
    if (constrained[k] == 0) all_nodes_.push_back(k);
  all_start_.assign({0, static_cast<std::uint32_t>(all_nodes_.size())});
  for (std::size_t halving = 0; halving < most_halvings; ++halving) {
    if (all_nodes_.size() >> (halving + 1) < least_of_group) break;
    std::vector<std::uint32_t> finer{0};
    for (std::size_t g = 0; g + 1 < all_start_.size(); ++g) {
      const auto begin = all_nodes_.begin() + all_start_[g], end = all_nodes_.begin() + all_start_[g + 1];
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
      finer.push_back(static_cast<std::uint32_t>(middle - all_nodes_.begin()));
      finer.push_back(all_start_[g + 1]);
    }
    all_start_ = std::move(finer);
  }
  all_arms_.resize(3 * all_nodes_.size());
  for (std::uint32_t g = 0; g + 1 < all_start_.size(); ++g) {
    const auto at = [&](std::uint32_t i) {
      return Vector3d(position[0][all_nodes_[i]], position[1][all_nodes_[i]], position[2][all_nodes_[i]]);
    };
    const double count = all_start_[g + 1] - all_start_[g];
    Vector3d centre = Vector3d::Zero();
    for (std::uint32_t i = all_start_[g]; i < all_start_[g + 1]; ++i) centre += at(i) / count;
    double square = 0.0;
    for (std::uint32_t i = all_start_[g]; i < all_start_[g + 1]; ++i) square += (at(i) - centre).squaredNorm() / count;
    const double radius = square > 0.0 ? std::sqrt(square) : 1.0;
    for (std::uint32_t i = all_start_[g]; i < all_start_[g + 1]; ++i) {
      group_[all_nodes_[i]] = g;
      place_[all_nodes_[i]] = i;
      const Vector3d own = (at(i) - centre) / radius;
      for (Index c = 0; c < 3; ++c)
        all_arms_[3 * std::size_t{i} + static_cast<std::size_t>(c)] = static_cast<float>(own[c]);
    }
  }
  const std::size_t groups = all_start_.size() - 1;
  blocks_.assign(36 * (groups * (groups + 1) / 2), 0.0);
}

void CoarseSpace::add_block(std::size_t row, std::size_t column, const Matrix3d& block) {
  const std::uint32_t i = group_[row], j = group_[column];
  if (i == none || j == none || i < j) return;
  const Matrix3d turn_i = cross_matrix(arm(row)), turn_j = cross_matrix(arm(column));
  Eigen::Map<Block> to = this->block(i, j);
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
      block(i, i).bottomRightCorner<3, 3>().noalias() += turn * turn.transpose();
      return;
    }
    Six by_first, by_second;
    if (i != none) {
      by_first << along, arm(first).cross(along);
      block(i, i).noalias() += by_first * by_first.transpose();
    }
    if (j != none) {
      by_second << along, arm(second).cross(along);
      block(j, j).noalias() += by_second * by_second.transpose();
    }
    if (i == none || j == none) return;
    if (i > j)
      block(i, j).noalias() -= by_first * by_second.transpose();
    else
      block(j, i).noalias() -= by_second * by_first.transpose();
  };
  add(q);
  if (!(a > least_across * q.squaredNorm())) return;
  for (Index c = 0; c < 3; ++c) add(std::sqrt(a) * Vector3d::Unit(c));
}

void CoarseSpace::factorise() {
  is_ready_ = false;
  const std::size_t groups = all_start_.size() - 1;
  const auto size = static_cast<Index>(6 * groups);
  // In units of its diagonal, which differs by the groups' stiffness.
  Eigen::VectorXd diagonal(size);
  for (std::size_t g = 0; g < groups; ++g) diagonal.segment<6>(static_cast<Index>(6 * g)) = block(g, g).diagonal();
  if (size == 0 || !(diagonal.minCoeff() > 0.0) || !diagonal.allFinite()) return;
  const Eigen::VectorXd unit = diagonal.cwiseSqrt().cwiseInverse();
  Eigen::MatrixXf scaled(size, size);
  for (std::size_t j = 0; j < groups; ++j) {
    const auto column = static_cast<Index>(6 * j);
    for (std::size_t i = j; i < groups; ++i) {
      const auto row = static_cast<Index>(6 * i);
      scaled.block<6, 6>(row, column) =
          (unit.segment<6>(row).asDiagonal() * block(i, j) * unit.segment<6>(column).asDiagonal()).cast<float>();
    }
  }
  scaled.diagonal().array() += static_cast<float>(added);
  const Eigen::LLT<Eigen::MatrixXf> factors(scaled);
  if (factors.info() != Eigen::Success || !factors.matrixLLT().diagonal().allFinite()) return;
  const std::size_t numbers = 6 * groups, padded = (numbers + 15) / 16 * 16;
  scale_.resize(numbers);
  right_.assign(padded, 0.0F);
  solution_.assign(padded, 0.0F);
  inverse_.assign(padded, 1.0F);
  lower_.assign(padded * padded, 0.0F);
  upper_.assign(padded * padded, 0.0F);
  for (std::size_t j = 0; j < numbers; ++j) {
    const auto column = static_cast<Index>(j);
    const auto l = factors.matrixLLT().col(column);
    scale_[j] = static_cast<float>(unit[column]);
    inverse_[j] = 1.0F / l[column];
    for (std::size_t i = j + 1; i < numbers; ++i)
      lower_[j * padded + i] = upper_[i * padded + j] = l[static_cast<Index>(i)];
  }
  node_ = all_nodes_;
  start_ = all_start_;
  arm_ = all_arms_;
  is_ready_ = true;
}

void CoarseSpace::follow(const std::vector<std::uint8_t>& constrained) {
  node_.clear();
  arm_.clear();
  start_.assign(1, 0);
  for (std::size_t g = 0; g + 1 < all_start_.size(); ++g) {
    for (std::uint32_t i = all_start_[g]; i < all_start_[g + 1]; ++i) {
      if (constrained[all_nodes_[i]] != 0) continue;
      node_.push_back(all_nodes_[i]);
      arm_.insert(arm_.end(), &all_arms_[3 * std::size_t{i}], &all_arms_[3 * std::size_t{i}] + 3);
    }
    start_.push_back(static_cast<std::uint32_t>(node_.size()));
  }
}

void CoarseSpace::solve() {
  for (std::size_t i = 0; i < scale_.size(); ++i) solution_[i] = scale_[i] * right_[i];
  // A number that is not finite would stay in the padding.
  std::fill(solution_.begin() + static_cast<std::ptrdiff_t>(scale_.size()), solution_.end(), 0.0F);
  kernels_.substitute(lower_.data(), upper_.data(), inverse_.data(), solution_.size(), solution_.data());
  for (std::size_t i = 0; i < scale_.size(); ++i) solution_[i] *= scale_[i];
}

}  // namespace springnet::layers
