// The rigid connections of some nodes at a state, without obstacles and bodies: what an impulse on one node does to all
// that connections join it to.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "constraints/rigid.hpp"
#include "constraints/vectors.hpp"
#include "simulation/model.hpp"

namespace springnet {

class StruckClusters {
 public:
  using Rods = RigidConnections::WithoutContact;

  explicit StruckClusters(const Model& model) : model_(model) {}
  // Of the clusters that these nodes belong to, at these positions, m.
  void set(const std::vector<std::uint32_t>& nodes, const springnet_const_vectors& position);
  void clear() { clusters_.clear(); }
  [[nodiscard]] bool any() const noexcept { return !clusters_.empty(); }
  [[nodiscard]] const std::map<std::uint32_t, Rods>& clusters() const noexcept { return clusters_; }
  // All nodes of these clusters, those that cannot move included.
  void add_nodes(std::vector<std::uint32_t>& nodes) const;
  // change(node, dv), m/s, for all nodes that impulses, [node] N s, move, and pass(node, impulse), N s, for what
  // reaches nodes that cannot move.
  template <class Change, class Pass>
  void spread(const std::map<std::uint32_t, Vector3>& impulses, const Change& change, const Pass& pass) const;

 private:
  const Model& model_;
  std::map<std::uint32_t, Rods> clusters_;  // [number]
};

template <class Change, class Pass>
void StruckClusters::spread(const std::map<std::uint32_t, Vector3>& impulses, const Change& change,
                            const Pass& pass) const {
  std::map<std::uint32_t, std::map<std::uint32_t, Vector3>> of_cluster;
  for (const auto& [node, impulse] : impulses) {
    const bool is_fixed = model_.contact.fixed()[node] != 0;
    if (is_fixed) pass(node, impulse);
    if (is_fixed || impulse.isZero(0.0)) continue;
    if (model_.rigid.is_joined(node))
      of_cluster[model_.rigid.cluster_of()[node]].emplace(node, impulse);
    else
      change(node, Vector3(impulse / model_.mass[node]));
  }
  for (const auto& [number, struck] : of_cluster) {
    std::vector<std::uint32_t> nodes;
    std::vector<Vector3> given;
    for (const auto& [node, impulse] : struck) {
      nodes.push_back(node);
      given.push_back(impulse);
    }
    const auto move = [&](std::uint32_t node, const Vector3& dv) {
      if (model_.contact.fixed()[node] == 0) change(node, dv);
    };
    clusters_.at(number).push(nodes, given, move, pass);
  }
}

}  // namespace springnet
