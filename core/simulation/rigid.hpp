// Rigid connections: nodes that they join form clusters, and a cluster's nodes get their velocities, positions and
// accelerations together, with the surfaces that they touch.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

#include "simulation/constraint_system.hpp"
#include "simulation/contact.hpp"

namespace springnet {

class RigidConnections {
 public:
  // References have to outlive it.
  RigidConnections(const Network& network, const std::vector<std::uint32_t>& user_number,
                   const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass, Contact& contact);

  struct Rod {
    std::uint32_t first, second;  // engine's
    double length;                // m
  };
  [[nodiscard]] bool any() const noexcept { return !rods_.empty(); }
  [[nodiscard]] const std::vector<Rod>& rods() const noexcept { return rods_; }
  // [node] number of its cluster, 0xffffffff: none; null without rigid connections.
  [[nodiscard]] const std::uint32_t* cluster_of() const noexcept {
    return cluster_of_.empty() ? nullptr : cluster_of_.data();
  }
  [[nodiscard]] std::size_t cluster_count() const noexcept { return clusters_.size(); }
  // Nodes of a cluster, by rising number.
  [[nodiscard]] const std::vector<std::uint32_t>& nodes_of(std::size_t cluster) const {
    return clusters_[cluster].nodes;
  }

  // Within a sweep: puts the outputs of a cluster's nodes where connections, fixation and surfaces allow, in velocity
  // and position. SPRINGNET_RECOVERABLE and a message if the lengths cannot be kept.
  springnet_status constrain(std::size_t cluster, const springnet_sweep& sweep, springnet_message& message) const;
  // Takes out of the accelerations of all clusters' nodes what the constraints do not allow. `force` ([rod] N, null:
  // not wanted) are the connections' tensions.
  void accelerate(const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                  const springnet_vectors& acceleration, double* force) const;
  void accelerate(std::size_t cluster, const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                  const springnet_vectors& acceleration, double* force) const {
    accelerate(clusters_[cluster], position, velocity, acceleration, force);
  }
  // The force of all connections on a node with these tensions ([rod] N).
  [[nodiscard]] Vector3 pull(std::uint32_t node, const springnet_const_vectors& position, const double* force) const;
  // Puts positions, then velocities, where the constraints of the clusters and of single nodes that slide allow,
  // weighted with the masses. Nodes that were just `stopped` by a surface may still move along it.
  springnet_status project(const springnet_vectors& position, const springnet_vectors& velocity,
                           springnet_message& message, const std::vector<std::uint32_t>& stopped = {}) const;
  // The greatest |rate of length| of a connection at these velocities, m/s.
  [[nodiscard]] double greatest_rate(const springnet_const_vectors& position,
                                     const springnet_const_vectors& velocity) const;
  // All rows that bind the motion at these positions, sliding nodes' included.
  [[nodiscard]] std::vector<ConstraintRow> rows(const springnet_const_vectors& position) const;
  // 1/m, or zero for a node that cannot move.
  [[nodiscard]] Eigen::Matrix3d mobility(std::uint32_t node) const;

 private:
  struct Cluster {
    std::vector<std::uint32_t> nodes;
    std::vector<std::uint32_t> rods;
  };
  struct Step;

  // Gauss-Newton towards the lengths and, for nodes that slide, their surfaces, weighted with the masses: positions
  // [node of the cluster] of those with `movable` change. False if it does not get there.
  bool correct_positions(const Cluster& cluster, const std::vector<Touch>& touches, std::vector<Vector3>& positions,
                         const std::vector<std::uint8_t>& movable) const;
  [[nodiscard]] std::vector<ConstraintRow> rows_of(const Cluster& cluster, const std::vector<Touch>& touches,
                                                   const std::vector<Vector3>& positions) const;
  springnet_status cannot_keep(const Cluster& cluster, springnet_message& message) const;
  void accelerate(const Cluster& cluster, const springnet_const_vectors& position,
                  const springnet_const_vectors& velocity, const springnet_vectors& acceleration, double* force) const;
  springnet_status project(const Cluster& cluster, const springnet_vectors& position, const springnet_vectors& velocity,
                           springnet_message& message, const std::vector<std::uint32_t>& stopped) const;
  [[nodiscard]] bool solve(Step& step) const;
  [[nodiscard]] bool revise_contacts(Step& step) const;
  [[nodiscard]] bool revise_contact(Step& step, std::size_t member) const;
  [[nodiscard]] Vector3 tension_at(const Step& step, std::size_t member) const;

  const std::vector<double>& mass_;
  Contact& contact_;
  const std::vector<std::uint32_t>& user_number_;
  std::vector<Rod> rods_;
  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> cluster_of_;
  std::vector<std::uint32_t> member_of_;  // [node] place in its cluster
};

}  // namespace springnet
