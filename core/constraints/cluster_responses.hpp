// How clusters of rigidly connected nodes answer impulses on some of their nodes: what moves one moves all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include <Eigen/Core>

#include <springnet/network.hpp>

#include "constraints/constraint_system.hpp"
#include "constraints/rigid.hpp"

namespace springnet {

class ClusterResponses {
 public:
  struct Cluster {
    std::uint32_t number;               // of RigidConnections
    std::vector<std::uint32_t> nodes;   // all of them
    std::vector<std::uint32_t> struck;  // those that impulses act on
    Eigen::MatrixXd response;           // 1/kg, three rows a node, three columns a struck one
  };
  // Of a struck node.
  struct Place {
    std::uint32_t cluster = none;
    std::uint32_t row = 0, column = 0;  // among all nodes of the cluster, and among those struck
  };
  static constexpr std::uint32_t none = 0xffffffffu;

  void clear();
  // Of the clusters that have some of these nodes, at these positions (m): see RigidConnections::response. loose:
  // clusters that answer as if no obstacles held them.
  void set(const RigidConnections& rigid, const Placement& at, const springnet_const_vectors& position,
           const std::vector<std::uint32_t>& struck, const ConstraintSystem::Mobility& free,
           const std::set<std::uint32_t>& loose = {});

  [[nodiscard]] const std::vector<Cluster>& clusters() const noexcept { return clusters_; }
  [[nodiscard]] bool any() const noexcept { return !clusters_.empty(); }
  // Null: it has no rigid connections, or is none of those struck.
  [[nodiscard]] const Place* find(std::uint32_t node) const noexcept {
    return node < places_.size() && places_[node].cluster != none ? &places_[node] : nullptr;
  }
  // 1/kg, what an impulse on the second gives the first; zero if they are in different clusters.
  [[nodiscard]] Matrix3 between(const Place& moved, const Place& struck) const {
    if (moved.cluster != struck.cluster) return Matrix3::Zero();
    return block(clusters_[moved.cluster], moved.row, struck.column);
  }
  // change(node, dv) for all nodes of the cluster, m/s, by an impulse, N s.
  template <class Change>
  void for_each_change(const Place& struck, const Vector3& impulse, const Change& change) const {
    const Cluster& cluster = clusters_[struck.cluster];
    for (std::size_t i = 0; i < cluster.nodes.size(); ++i)
      change(cluster.nodes[i], Vector3(block(cluster, i, struck.column) * impulse));
  }
  // What all impulses, impulse(node), N s, on the cluster of this node give it, m/s.
  template <class Impulse>
  [[nodiscard]] Vector3 change(const Place& moved, const Impulse& impulse) const {
    const Cluster& cluster = clusters_[moved.cluster];
    Vector3 sum = Vector3::Zero();
    for (std::size_t j = 0; j < cluster.struck.size(); ++j)
      sum += block(cluster, moved.row, j) * Vector3(impulse(cluster.struck[j]));
    return sum;
  }

 private:
  [[nodiscard]] static Matrix3 block(const Cluster& of, std::size_t row, std::size_t column) {
    return of.response.block<3, 3>(static_cast<Eigen::Index>(3 * row), static_cast<Eigen::Index>(3 * column));
  }

  std::vector<Cluster> clusters_;
  std::vector<Place> places_;  // [node]; empty before the first
};

}  // namespace springnet
