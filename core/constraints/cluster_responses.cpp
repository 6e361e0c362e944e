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
                           const std::vector<std::uint32_t>& struck, const ConstraintSystem::Mobility& free,
                           const std::set<std::uint32_t>& loose) {
  clear();
  const std::uint32_t* const cluster_of = rigid.cluster_of();
  if (cluster_of == nullptr) return;
  std::map<std::uint32_t, std::vector<std::uint32_t>> of_cluster;
  for (const std::uint32_t k : struck)
    if (cluster_of[k] != none) of_cluster[cluster_of[k]].push_back(k);
  for (auto& [number, nodes] : of_cluster) {
    std::sort(nodes.begin(), nodes.end());  // whatever the order in which pairs were found
    clusters_.push_back({number, rigid.nodes_of(number), nodes,
                         rigid.response(at, number, position, nodes, free, !loose.contains(number))});
    const std::vector<std::uint32_t>& all = clusters_.back().nodes;
    for (std::size_t j = 0; j < nodes.size(); ++j) {
      if (places_.size() <= nodes[j]) places_.resize(nodes[j] + std::size_t{1});
      const auto row = std::lower_bound(all.begin(), all.end(), nodes[j]) - all.begin();
      places_[nodes[j]] = {static_cast<std::uint32_t>(clusters_.size() - 1), static_cast<std::uint32_t>(row),
                           static_cast<std::uint32_t>(j)};
    }
  }
}

}  // namespace springnet
