#include "constraints/cluster_responses.hpp"

#include <algorithm>
#include <map>

namespace springnet {

void ClusterResponses::clear() {
  for (const Cluster& cluster : clusters_)
    for (const std::uint32_t k : cluster.struck) places_[k] = {};
  clusters_.clear();
}

void ClusterResponses::set(const RigidConnections& rigid, const Placement& at, const springnet_const_vectors& position,
                           const std::vector<std::uint32_t>& struck, bool on_obstacles,
                           const ConstraintSystem::Mobility& free) {
  clear();
  const std::uint32_t* const cluster_of = rigid.cluster_of();
  if (cluster_of == nullptr) return;
  std::map<std::uint32_t, std::vector<std::uint32_t>> of_cluster;
  for (const std::uint32_t k : struck)
    if (cluster_of[k] != none) of_cluster[cluster_of[k]].push_back(k);
  for (auto& [number, nodes] : of_cluster) {
    std::sort(nodes.begin(), nodes.end());  // whatever the order in which pairs were found
    clusters_.push_back(
        {rigid.nodes_of(number), nodes, rigid.response(at, number, position, nodes, on_obstacles, free)});
    const std::vector<std::uint32_t>& all = clusters_.back().nodes;
    for (std::size_t j = 0; j < nodes.size(); ++j) {
      if (places_.size() <= nodes[j]) places_.resize(nodes[j] + std::size_t{1});
      const auto row = std::lower_bound(all.begin(), all.end(), nodes[j]) - all.begin();
      places_[nodes[j]] = {static_cast<std::uint32_t>(clusters_.size() - 1), static_cast<std::uint32_t>(row),
                           static_cast<std::uint32_t>(j)};
    }
  }
}

// W - W G^T (G W G^T)^-1 G W, the columns of some nodes.
Eigen::MatrixXd RigidConnections::response(const Placement& at, std::size_t number,
                                           const springnet_const_vectors& position,
                                           const std::vector<std::uint32_t>& struck, bool on_obstacles,
                                           const ConstraintSystem::Mobility& free) const {
  const Cluster& cluster = clusters_[number];
  std::vector<Vector3> positions;
  std::vector<Touch> touches;
  for (const std::uint32_t k : cluster.nodes) {
    positions.push_back(vector_at(position, k));
    touches.push_back(on_obstacles ? contact_.now(k) : Touch{});
  }
  const auto mobility = [&](std::uint32_t node) {
    const bool is_held = on_obstacles ? contact_.constrained()[node] != 0 : contact_.fixed()[node] != 0;
    return is_held ? Matrix3(Matrix3::Zero()) : Matrix3(free(node));
  };
  ConstraintSystem system;
  system.set(rows_of(at, cluster, touches, positions), mobility);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(3 * cluster.nodes.size()),
                                                 static_cast<Eigen::Index>(3 * struck.size()));
  for (std::size_t j = 0; j < struck.size(); ++j) {
    const Matrix3 own = mobility(struck[j]);
    for (Eigen::Index c = 0; c < 3; ++c) {
      const Eigen::Index column = static_cast<Eigen::Index>(3 * j) + c;
      const auto add = [&](std::uint32_t node, const Vector3& change) {
        result.block<3, 1>(3 * static_cast<Eigen::Index>(member_of_[node]), column) += change;
      };
      add(struck[j], own.col(c));
      const auto velocity = [&](std::uint32_t node) {
        return node == struck[j] ? Vector3(own.col(c)) : Vector3(Vector3::Zero());
      };
      system.for_each_change(system.solve(-system.rates(velocity)), add);
    }
  }
  return result;
}

}  // namespace springnet
