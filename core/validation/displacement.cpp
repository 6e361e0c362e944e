#include "validation/displacement.hpp"

#include <algorithm>
#include <numeric>

#include <Eigen/Dense>

namespace springnet {

namespace {

using Points = Eigen::Matrix3Xd;

// Maximum distance of `now` from `start` after the best rigid motion: W. Kabsch, A solution for the best rotation to
// relate two sets of vectors, Acta Cryst. A32 (1976) 922-923. Both are relative to their centres.
double greatest_deformation(const Points& start, const Points& now) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(now * start.transpose(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d turn = svd.matrixU();  // times V^T: the rotation
  // A rotation, not a reflection: flip the direction of the smallest singular value.
  if ((turn * svd.matrixV().transpose()).determinant() < 0.0) turn.col(2) = -turn.col(2);
  return (now - turn * svd.matrixV().transpose() * start).colwise().norm().maxCoeff();
}

}  // namespace

DisplacementNorm::DisplacementNorm(const Network& network) {
  std::vector<bool> in_body(network.nodes().size(), false);
  for (const Node& node : network.nodes()) start_.push_back(node.position);
  for (const Body& body : network.bodies()) {
    if (body.node_count == 0) continue;
    auto& nodes = sets_.emplace_back(body.node_count);
    std::iota(nodes.begin(), nodes.end(), body.first_node);
    for (const NodeIndex node : nodes) in_body[node] = true;
  }
  std::vector<NodeIndex> others;
  for (NodeIndex node = 0; node < in_body.size(); ++node) {
    if (!in_body[node]) others.push_back(node);
  }
  if (!others.empty()) sets_.push_back(std::move(others));
}

void DisplacementNorm::add(double time, const ConstNodeMap& positions, const std::vector<std::uint32_t>& columns) {
  for (const std::vector<NodeIndex>& nodes : sets_) {
    Points start(3, static_cast<Eigen::Index>(nodes.size())), now = start;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      start.col(column) = start_[nodes[k]];
      now.col(column) = positions.col(static_cast<Eigen::Index>(columns[nodes[k]]));
      const double distance = (now.col(column) - start.col(column)).norm();
      if (distance <= result_.max) continue;
      result_.max = distance;
      result_.node = nodes[k];
      result_.time = time;
    }
    start.colwise() -= start.rowwise().mean().eval();
    now.colwise() -= now.rowwise().mean().eval();
    result_.deformation = std::max(result_.deformation, greatest_deformation(start, now));
  }
}

}  // namespace springnet
