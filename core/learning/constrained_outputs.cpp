#include "learning/constrained_outputs.hpp"

#include <algorithm>
#include <utility>

namespace springnet::learning {

using Eigen::Index;
using Eigen::VectorXd;

void ConstrainedOutputs::begin(std::size_t nodes, double c, double w) {
  nodes_ = nodes;
  c_ = c;
  w_ = w;
  blocks_.clear();
}

void ConstrainedOutputs::add(std::vector<std::uint32_t> nodes, Eigen::MatrixXd derivative, Eigen::MatrixXd by_mass,
                             Eigen::MatrixXd by_times) {
  blocks_.push_back({std::move(nodes), std::move(derivative), std::move(by_mass), std::move(by_times)});
}

void ConstrainedOutputs::set_friction(std::int32_t first, std::int32_t second,
                                      const Eigen::Matrix<double, 6, 2>& by_friction) {
  Block& block = blocks_.back();
  block.surfaces[0] = first;
  block.surfaces[1] = second;
  block.by_friction = by_friction;
}

std::vector<layers::NodeResponse> ConstrainedOutputs::responses(bool transposed) const {
  std::vector<layers::NodeResponse> result;
  for (const Block& block : blocks_) {
    if (block.nodes.size() != 1) continue;
    Eigen::Matrix3d own = block.derivative.topRightCorner<3, 3>() / w_;
    if (transposed) own.transposeInPlace();
    result.push_back({block.nodes.front(), own, Eigen::Matrix3d::Zero()});
  }
  std::sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
  return result;
}

VectorXd ConstrainedOutputs::gather(const Block& block, const VectorXd& of) const {
  VectorXd result(static_cast<Index>(3 * block.nodes.size()));
  Index next = 0;
  for (const std::uint32_t node : block.nodes)
    for (std::size_t axis = 0; axis < 3; ++axis) result[next++] = of[static_cast<Index>(axis * nodes_ + node)];
  return result;
}

void ConstrainedOutputs::scatter(const Block& block, const Eigen::Ref<const VectorXd>& from, VectorXd& to) const {
  Index next = 0;
  for (const std::uint32_t node : block.nodes)
    for (std::size_t axis = 0; axis < 3; ++axis) to[static_cast<Index>(axis * nodes_ + node)] = from[next++];
}

void ConstrainedOutputs::from_start(const VectorXd& dp, const VectorXd& dv, VectorXd& end_dp, VectorXd& end_dv) const {
  end_dp = dp + c_ * dv;
  end_dv.setZero(dv.size());
  for (const Block& block : blocks_) {
    const auto size = static_cast<Index>(3 * block.nodes.size());
    const VectorXd both = block.derivative.leftCols(size) * gather(block, dp) +
                          block.derivative.middleCols(size, size) * gather(block, dv);
    scatter(block, both.head(size), end_dp);
    scatter(block, both.tail(size), end_dv);
  }
}

void ConstrainedOutputs::from_free(const VectorXd& free, VectorXd& end_dp, VectorXd& end_dv) const {
  end_dp = w_ * free;
  end_dv = free;
  for (const Block& block : blocks_) {
    const auto size = static_cast<Index>(3 * block.nodes.size());
    const VectorXd both = block.derivative.rightCols(size) * gather(block, free);
    scatter(block, both.head(size), end_dp);
    scatter(block, both.tail(size), end_dv);
  }
}

void ConstrainedOutputs::clear_unused(VectorXd& free) const {
  for (const Block& block : blocks_) {
    const auto size = static_cast<Index>(3 * block.nodes.size());
    if (block.derivative.rightCols(size).isZero(0.0)) scatter(block, VectorXd::Zero(size), free);
  }
}

void ConstrainedOutputs::add_masses(const VectorXd& masses, VectorXd& end_dp, VectorXd& end_dv) const {
  for (const Block& block : blocks_) {
    if (block.by_mass.size() == 0) continue;
    VectorXd own(static_cast<Index>(block.nodes.size()));
    for (std::size_t i = 0; i < block.nodes.size(); ++i) own[static_cast<Index>(i)] = masses[block.nodes[i]];
    const VectorXd both = block.by_mass * own;
    const Index size = 3 * own.size();
    scatter(block, gather(block, end_dp) + both.head(size), end_dp);
    scatter(block, gather(block, end_dv) + both.tail(size), end_dv);
  }
}

void ConstrainedOutputs::add_friction(const VectorXd& coefficients, VectorXd& end_dp, VectorXd& end_dv) const {
  for (const Block& block : blocks_) {
    for (Index i = 0; i < 2; ++i) {
      if (block.surfaces[i] < 0 || coefficients[block.surfaces[i]] == 0.0) continue;
      const Eigen::Matrix<double, 6, 1> own = coefficients[block.surfaces[i]] * block.by_friction.col(i);
      scatter(block, gather(block, end_dp) + own.head<3>(), end_dp);
      scatter(block, gather(block, end_dv) + own.tail<3>(), end_dv);
    }
  }
}

VectorXd ConstrainedOutputs::to_friction(const VectorXd& end_dp, const VectorXd& end_dv, Index surfaces) const {
  VectorXd result = VectorXd::Zero(surfaces);
  for (const Block& block : blocks_)
    for (Index i = 0; i < 2; ++i)
      if (block.surfaces[i] >= 0)
        result[block.surfaces[i]] += block.by_friction.col(i).head<3>().dot(gather(block, end_dp)) +
                                     block.by_friction.col(i).tail<3>().dot(gather(block, end_dv));
  return result;
}

std::optional<std::uint32_t> ConstrainedOutputs::write_times(bool at_end, VectorXd& end_dp, VectorXd& end_dv) const {
  for (const Block& block : blocks_) {
    if (block.by_times.size() == 0) return block.nodes.front();
    const auto size = static_cast<Index>(3 * block.nodes.size());
    const VectorXd both = block.by_times.col(at_end ? 1 : 0);
    scatter(block, both.head(size), end_dp);
    scatter(block, both.tail(size), end_dv);
  }
  return std::nullopt;
}

void ConstrainedOutputs::to_start(const VectorXd& end_dp, const VectorXd& end_dv, VectorXd& dp, VectorXd& dv) const {
  dp = end_dp;
  dv = c_ * end_dp;
  for (const Block& block : blocks_) {
    const auto size = static_cast<Index>(3 * block.nodes.size());
    VectorXd both(2 * size);
    both << gather(block, end_dp), gather(block, end_dv);
    const VectorXd start = block.derivative.leftCols(2 * size).transpose() * both;
    scatter(block, start.head(size), dp);
    scatter(block, start.tail(size), dv);
  }
}

void ConstrainedOutputs::to_free(const VectorXd& end_dp, const VectorXd& end_dv, VectorXd& free) const {
  free = w_ * end_dp + end_dv;
  for (const Block& block : blocks_) {
    const auto size = static_cast<Index>(3 * block.nodes.size());
    VectorXd both(2 * size);
    both << gather(block, end_dp), gather(block, end_dv);
    scatter(block, block.derivative.rightCols(size).transpose() * both, free);
  }
}

VectorXd ConstrainedOutputs::to_masses(const VectorXd& end_dp, const VectorXd& end_dv) const {
  VectorXd result = VectorXd::Zero(static_cast<Index>(nodes_));
  for (const Block& block : blocks_) {
    if (block.by_mass.size() == 0) continue;
    const auto size = static_cast<Index>(3 * block.nodes.size());
    VectorXd both(2 * size);
    both << gather(block, end_dp), gather(block, end_dv);
    const VectorXd own = block.by_mass.transpose() * both;
    for (std::size_t i = 0; i < block.nodes.size(); ++i) result[block.nodes[i]] += own[static_cast<Index>(i)];
  }
  return result;
}

}  // namespace springnet::learning
