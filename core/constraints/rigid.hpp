// Rigid connections. The nodes that they join form clusters; velocities, positions and accelerations of a cluster are
// solved together, with its contacts.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

#include "constraints/constraint_system.hpp"
#include "constraints/contact.hpp"
#include "constraints/vectors.hpp"

namespace springnet {

class RigidConnections {
 public:
  // The arguments must outlive it.
  RigidConnections(const Network& network, const std::vector<std::uint32_t>& user_number,
                   const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass, Contact& contact);

  struct Rod {
    std::uint32_t first, second;  // engine's numbers
    double length;                // m
  };
  [[nodiscard]] bool any() const noexcept { return !rods_.empty(); }
  [[nodiscard]] const std::vector<Rod>& rods() const noexcept { return rods_; }
  // [node] number of its cluster, 0xffffffff: none; null without rigid connections.
  [[nodiscard]] const std::uint32_t* cluster_of() const noexcept {
    return cluster_of_.empty() ? nullptr : cluster_of_.data();
  }
  [[nodiscard]] std::size_t cluster_count() const noexcept { return clusters_.size(); }
  // Nodes of a cluster, in ascending order.
  [[nodiscard]] const std::vector<std::uint32_t>& nodes_of(std::size_t cluster) const {
    return clusters_[cluster].nodes;
  }

  // Within a sweep: constrains positions and velocities of a cluster's outputs by connections, fixation and surfaces.
  // SPRINGNET_RECOVERABLE and a message if the lengths cannot be kept.
  springnet_status constrain(const Placement& end, std::size_t cluster, const springnet_sweep& sweep,
                             springnet_message& message) const;
  // Constrains the accelerations of a cluster's nodes. `force` ([rod] N, null: not wanted) receives the tensions of its
  // connections. Node `without` counts as released from its surfaces.
  void accelerate(const Placement& at, std::size_t cluster, const springnet_const_vectors& position,
                  const springnet_const_vectors& velocity, const springnet_vectors& acceleration, double* force,
                  std::uint32_t without = ConstraintRow::no_node) const;
  // A cluster at a state, with connections and fixation but without contact.
  class WithoutContact {
   public:
    // Arrays [node] of the functions below are in the order of nodes_of().
    WithoutContact(const RigidConnections& rigid, std::size_t cluster, const springnet_const_vectors& position);
    // Projects accelerations ([node], m/s^2) onto those that the connections allow.
    void accelerate(const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                    std::vector<Vector3>& acceleration) const;
    // For a straight step of h seconds from those positions: corrects `velocity` ([node], m/s) by impulses along the
    // connections at the start of the step, and with it `position` ([node], m) at the end, until the lengths there are
    // kept. False if they cannot be kept.
    [[nodiscard]] bool keep_lengths(double h, std::vector<Vector3>& velocity, std::vector<Vector3>& position) const;
    // Projects velocities onto those that keep the lengths. Fixed and prescribed nodes keep theirs; pass(node, impulse)
    // reports the impulses on them, N s.
    template <class Pass>
    void pull_along(const springnet_vectors& velocity, Pass&& pass) const;
    // Projects velocities ([node], m/s) onto those that the connections allow.
    void project(std::vector<Vector3>& velocity) const;
    // The same for the engine's arrays; fixed and sticking nodes keep their velocities.
    void project(const springnet_vectors& velocity) const;
    // Effective mobility of some nodes, 1/kg, three rows and columns a node.
    [[nodiscard]] Eigen::MatrixXd mobility(const std::vector<std::uint32_t>& nodes) const;
    // Response to impulses (N s) on these nodes: calls change(node, dv), m/s, for velocity changes and pass(node,
    // impulse), N s, for the impulses on fixed nodes.
    template <class Change, class Pass>
    void push(const std::vector<std::uint32_t>& nodes, const std::vector<Vector3>& impulses, Change&& change,
              Pass&& pass) const;

   private:
    [[nodiscard]] Matrix3 own_mobility(std::uint32_t node) const;  // 1/mass, zero for a fixed node
    template <class Pass>
    void pass_to_fixed(const Eigen::VectorXd& multipliers, Pass&& pass) const {
      system_.for_each_impulse(multipliers, [&](std::uint32_t node, const Vector3& impulse) {
        if (rigid_.contact_.fixed()[node] != 0) pass(node, impulse);
      });
    }

    const RigidConnections& rigid_;
    const std::vector<std::uint32_t>& nodes_;
    const std::vector<std::uint32_t>& rods_;
    ConstraintSystem system_;
  };
  // The force (N) of all connections on a node, from their tensions ([rod] N).
  [[nodiscard]] Vector3 connection_force(std::uint32_t node, const springnet_const_vectors& position,
                                         const double* force) const;
  // `impulses` ([node of the cluster], N s) are those of the connections. Given for nodes that can move; this finds the
  // connections' multipliers from them and sets the impulses on fixed nodes.
  void find_fixed_impulses(std::size_t cluster, const springnet_const_vectors& position,
                           std::vector<Vector3>& impulses) const;
  // Projects positions, then velocities, of a cluster onto its constraints, weighted with the masses. Nodes just
  // `stopped` by a surface may still move along it; those of `rebounds` start on their surfaces if the lengths allow.
  springnet_status project(const Placement& at, std::size_t cluster, const springnet_vectors& position,
                           const springnet_vectors& velocity, springnet_message& message,
                           const std::vector<std::uint32_t>& stopped = {}, const Rebounds& rebounds = {}) const;
  // The greatest |rate of length| of a connection at these velocities, m/s.
  [[nodiscard]] double max_length_rate(const springnet_const_vectors& position,
                                       const springnet_const_vectors& velocity) const;
  // The constraint rows of all rods at these positions.
  [[nodiscard]] std::vector<ConstraintRow> rows(const springnet_const_vectors& position) const;
  // Adds those of a cluster, in the order of its connections.
  void add_rows(std::size_t cluster, const springnet_const_vectors& position, std::vector<ConstraintRow>& rows) const;
  // use(length less that which it should have), m, in this order.
  template <class Use>
  void for_each_stretch(std::size_t cluster, const springnet_const_vectors& position, const Use& use) const {
    for (const std::uint32_t r : clusters_[cluster].rods)
      use((vector_at(position, rods_[r].first) - vector_at(position, rods_[r].second)).norm() - rods_[r].length);
  }
  // How a cluster answers impulses on some of its nodes, `struck`, 1/kg: three rows a node of the cluster, three
  // columns a struck one. Nodes on obstacles stay on them, and slide or stick as they do now, unless they answer as if
  // there were none. free: of nodes that can move, 1/kg.
  [[nodiscard]] Eigen::MatrixXd response(const Placement& at, std::size_t cluster,
                                         const springnet_const_vectors& position,
                                         const std::vector<std::uint32_t>& struck,
                                         const ConstraintSystem::Mobility& free, bool with_obstacles = true) const;
  // Whether a node has rigid connections.
  [[nodiscard]] bool is_joined(std::uint32_t node) const noexcept {
    return !cluster_of_.empty() && cluster_of_[node] != ConstraintRow::no_node;
  }
  // 1/mass, zero for a node that cannot move; 1/kg.
  [[nodiscard]] Eigen::Matrix3d mobility(std::uint32_t node) const;

 private:
  struct Cluster {
    std::vector<std::uint32_t> nodes;
    std::vector<std::uint32_t> rods;
  };
  class Step;  // of a cluster, within a sweep

  // Gauss-Newton iteration for the lengths and the surfaces of sliding nodes, weighted with the masses. Changes
  // positions ([node of the cluster], m) of `movable` nodes. False if it does not converge.
  bool correct_positions(const Placement& at, const Cluster& cluster, const std::vector<Touch>& touches,
                         std::vector<Vector3>& positions, const std::vector<std::uint8_t>& movable) const;
  [[nodiscard]] std::vector<ConstraintRow> rows_of(const Placement& at, const Cluster& cluster,
                                                   const std::vector<Touch>& touches,
                                                   const std::vector<Vector3>& positions) const;
  [[nodiscard]] std::vector<ConstraintRow> rods_of(const Cluster& cluster, const std::vector<Vector3>& positions) const;
  springnet_status fail_lengths(const Cluster& cluster, springnet_message& message) const;

  const std::vector<double>& mass_;
  Contact& contact_;
  const std::vector<std::uint32_t>& user_number_;
  std::vector<Rod> rods_;
  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> cluster_of_;
  std::vector<std::uint32_t> member_of_;  // [node] place in its cluster
};

template <class Change, class Pass>
void RigidConnections::WithoutContact::push(const std::vector<std::uint32_t>& nodes,
                                            const std::vector<Vector3>& impulses, Change&& change, Pass&& pass) const {
  std::vector<Vector3> struck(nodes_.size(), Vector3::Zero());  // m/s
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (rigid_.contact_.fixed()[nodes[i]] != 0) continue;
    const Vector3 dv = impulses[i] / rigid_.mass_[nodes[i]];
    change(nodes[i], dv);
    struck[rigid_.member_of_[nodes[i]]] += dv;
  }
  const Eigen::VectorXd multipliers = system_.solve(
      -system_.rates([&](std::uint32_t node) -> const Vector3& { return struck[rigid_.member_of_[node]]; }));
  system_.for_each_change(multipliers, change);
  pass_to_fixed(multipliers, pass);
}

template <class Pass>
void RigidConnections::WithoutContact::pull_along(const springnet_vectors& velocity, Pass&& pass) const {
  Eigen::VectorXd rates = system_.rates([&](std::uint32_t node) { return vector_at(velocity, node); });
  // A connection between two fixed ends cannot be corrected.
  for (std::size_t r = 0; r < system_.rows().size(); ++r) {
    const ConstraintRow& row = system_.rows()[r];
    const std::vector<std::uint8_t>& fixed = rigid_.contact_.fixed();
    if (fixed[row.first] != 0 && fixed[row.second] != 0) rates[static_cast<Eigen::Index>(r)] = 0.0;
  }
  const Eigen::VectorXd multipliers = system_.solve(-rates);
  system_.for_each_change(multipliers, [&](std::uint32_t node, const Vector3& change) {
    if (rigid_.contact_.fixed()[node] == 0) put_vector(velocity, node, vector_at(velocity, node) + change);
  });
  pass_to_fixed(multipliers, pass);
}

}  // namespace springnet
