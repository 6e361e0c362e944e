#include "simulation/struck_clusters.hpp"

#include <algorithm>

namespace springnet {

void StruckClusters::set(const std::vector<std::uint32_t>& nodes, const springnet_const_vectors& position) {
  clusters_.clear();
  if (!model_.rigid.any()) return;
  for (const std::uint32_t k : nodes) {
    if (!model_.rigid.is_joined(k)) continue;
    const std::uint32_t number = model_.rigid.cluster_of()[k];
    if (!clusters_.contains(number)) clusters_.emplace(number, Rods(model_.rigid, number, position));
  }
}

void StruckClusters::add_nodes(std::vector<std::uint32_t>& nodes) const {
  if (clusters_.empty()) return;
  for (const auto& [number, rods] : clusters_) {
    const std::vector<std::uint32_t>& all = model_.rigid.nodes_of(number);
    nodes.insert(nodes.end(), all.begin(), all.end());
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

}  // namespace springnet
