// Rigid connections: nodes that they join form clusters, and a cluster's nodes get their velocities, positions and
// accelerations together, with the surfaces that they touch.
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
  springnet_status constrain(const Placement& end, std::size_t cluster, const springnet_sweep& sweep,
                             springnet_message& message) const;
  // Takes out of the accelerations of a cluster's nodes what the constraints do not allow. `force` ([rod] N, null: not
  // wanted) are its connections' tensions. No surface holds `without`, as if it had been let go.
  void accelerate(const Placement& at, std::size_t cluster, const springnet_const_vectors& position,
                  const springnet_const_vectors& velocity, const springnet_vectors& acceleration, double* force,
                  std::uint32_t without = ConstraintRow::no_node) const;
  // What the nodes of a cluster do at a state if no surface acted, but connections and fixation did.
  class Unsupported {
   public:
    // Calls of the other functions speak of a cluster's nodes, in the order of nodes_of().
    Unsupported(const RigidConnections& rigid, std::size_t cluster, const springnet_const_vectors& position);
    // Takes out of accelerations what connections do not allow; [node].
    void accelerate(const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                    std::vector<Vector3>& acceleration) const;
    // In a step of h seconds that goes straight from those positions: `velocity` changes, by impulses along the
    // connections' directions at its start, and `position`, at its end, with it, until lengths are kept there. [node].
    // False if they cannot be.
    [[nodiscard]] bool keep_lengths(double h, std::vector<Vector3>& velocity, std::vector<Vector3>& position) const;
    // Impulses of the connections give velocities that keep their lengths; those of fixed and moved nodes stay:
    // pass(node, impulse) tells what reaches these, N s.
    template <class Pass>
    void pull_along(const springnet_vectors& velocity, Pass&& pass) const;
    // Takes out of velocities what connections do not allow; [node].
    void project(std::vector<Vector3>& velocity) const;
    // The same of the engine's, beside nodes that are fixed or stick.
    void project(const springnet_vectors& velocity) const;
    // Effective mobility of some nodes, 1/kg: three rows and columns each.
    [[nodiscard]] Eigen::MatrixXd mobility(const std::vector<std::uint32_t>& nodes) const;
    // How velocities change by impulses on these nodes (m/s), and what reaches nodes that cannot move (N s): calls
    // change(node, dv) and pass(node, impulse).
    template <class Change, class Pass>
    void push(const std::vector<std::uint32_t>& nodes, const std::vector<Vector3>& impulses, Change&& change,
              Pass&& pass) const;

   private:
    [[nodiscard]] Matrix3 own_mobility(std::uint32_t node) const;  // 1/m, or zero for a node that is fixed
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
  // The force of all connections on a node with these tensions ([rod] N).
  [[nodiscard]] Vector3 pull(std::uint32_t node, const springnet_const_vectors& position, const double* force) const;
  // The impulses of connections that explain what they gave the nodes of a cluster that can move ([node of the cluster]
  // N s), and from that what they gave the others, which are set.
  void pass_on(std::size_t cluster, const springnet_const_vectors& position, std::vector<Vector3>& impulses) const;
  // Puts positions, then velocities, of a cluster where the constraints allow, weighted with the masses. Nodes that
  // were just `stopped` by a surface may still move along it; those of `rebounds` begin on their surfaces, where
  // lengths let them.
  springnet_status project(const Placement& at, std::size_t cluster, const springnet_vectors& position,
                           const springnet_vectors& velocity, springnet_message& message,
                           const std::vector<std::uint32_t>& stopped = {}, const Rebounds& rebounds = {}) const;
  // The greatest |rate of length| of a connection at these velocities, m/s.
  [[nodiscard]] double greatest_rate(const springnet_const_vectors& position,
                                     const springnet_const_vectors& velocity) const;
  // The rows of all rods at these positions.
  [[nodiscard]] std::vector<ConstraintRow> rows(const springnet_const_vectors& position) const;
  // 1/m, or zero for a node that cannot move.
  [[nodiscard]] Eigen::Matrix3d mobility(std::uint32_t node) const;

 private:
  struct Cluster {
    std::vector<std::uint32_t> nodes;
    std::vector<std::uint32_t> rods;
  };
  class Step;  // of a cluster, within a sweep

  // Gauss-Newton towards the lengths and, for nodes that slide, their surfaces, weighted with the masses: positions
  // [node of the cluster] of those with `movable` change. False if it does not get there.
  bool correct_positions(const Placement& at, const Cluster& cluster, const std::vector<Touch>& touches,
                         std::vector<Vector3>& positions, const std::vector<std::uint8_t>& movable) const;
  [[nodiscard]] std::vector<ConstraintRow> rows_of(const Placement& at, const Cluster& cluster,
                                                   const std::vector<Touch>& touches,
                                                   const std::vector<Vector3>& positions) const;
  [[nodiscard]] std::vector<ConstraintRow> rods_of(const Cluster& cluster, const std::vector<Vector3>& positions) const;
  springnet_status cannot_keep(const Cluster& cluster, springnet_message& message) const;

  const std::vector<double>& mass_;
  Contact& contact_;
  const std::vector<std::uint32_t>& user_number_;
  std::vector<Rod> rods_;
  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> cluster_of_;
  std::vector<std::uint32_t> member_of_;  // [node] place in its cluster
};

template <class Change, class Pass>
void RigidConnections::Unsupported::push(const std::vector<std::uint32_t>& nodes, const std::vector<Vector3>& impulses,
                                         Change&& change, Pass&& pass) const {
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
void RigidConnections::Unsupported::pull_along(const springnet_vectors& velocity, Pass&& pass) const {
  Eigen::VectorXd rates = system_.rates([&](std::uint32_t node) { return vector_at(velocity, node); });
  // Between two ends that stay nothing can be kept.
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
