// One sweep of the recurrent network as a linear map: what it makes of an error in the outputs.
//
// With the error u of the velocities, that of the positions is t u (t is theta times the time step), and the springs
// answer with
//   acceleration error = -(A_t u) / t,   A_t = t^2 M^-1 K + t M^-1 D
// (generalised to neurons: A_t = W (t^2 K + t D) - t^2 a_p - t a_v with the blocks W, a_p, a_v of the nodes). A_k means
// the 3 x 3 block on its diagonal. A sweep does
//   synchronous          u <- -A_t u
//   wavefront            the same node by node, with the newest values of the others
//   block, coloured      node by node u_k <- -(I + A_k)^-1 (rest of row k of A_t) u
// and rigid connections project what comes out onto the motions that they allow, weighted with the inertia with which
// a node answers to an impulse: its mass, with blocks m_k (I + A_k).
//
// Vectors have 3 numbers a node, those of fixed nodes 0, multiplied with the roots of the masses: A_t is symmetric
// then.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <springnet/inspection.hpp>

#include "inspection/linearised.hpp"
#include "inspection/orders.hpp"
#include "inspection/projection.hpp"

namespace springnet {

class LinearSweep {
 public:
  // References have to outlive it. The rule is not newton.
  LinearSweep(const Network& network, const LinearNetwork& linear, const Joints& joints, UpdateRule rule);

  // Puts zeros where nodes are fixed. apply() keeps them.
  void restrict(Eigen::VectorXd& u) const;
  // s, > 0. Has to be called before apply().
  void set_time_constant(double t);
  void apply(Eigen::VectorXd& u);

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(3 * free_.size()); }
  // What apply() visits: for budgets.
  [[nodiscard]] std::size_t work() const { return joints_.count() + 4 * linear_.elements.all().size() + free_.size(); }
  // Velocity error of a node, from a vector. Any unit.
  [[nodiscard]] Vector3 velocity(const Eigen::VectorXd& u, NodeIndex node) const {
    return inverse_root_[node] * u.segment<3>(at(node));
  }
  // Whether A_t is symmetric: all neurons are like mass points or a drag.
  [[nodiscard]] bool symmetric() const { return symmetric_; }

 private:
  static Eigen::Index at(NodeIndex node) { return 3 * static_cast<Eigen::Index>(node); }
  [[nodiscard]] bool blocks() const { return rule_ == UpdateRule::block || rule_ == UpdateRule::coloured; }
  [[nodiscard]] Vector3 updated(NodeIndex node, const Eigen::VectorXd& u) const;
  // (t^2 K + t D) of elements between a node and all others, times their velocities.
  [[nodiscard]] Vector3 pulled_by_elements(NodeIndex node, const Eigen::VectorXd& u) const;
  // Sum of dV/dp times velocities over the nodes of each enclosed volume: of all, and as one node changes.
  void sum_rates(const Eigen::VectorXd& u);
  void change_rates(NodeIndex node, const Vector3& change);
  void put(NodeIndex node, const Vector3& value, Eigen::VectorXd& u);
  void update_cluster(RigidProjection& cluster, Eigen::VectorXd& u);

  const LinearNetwork& linear_;
  const Joints& joints_;
  UpdateRule rule_;
  bool symmetric_ = true;
  std::vector<std::uint32_t> cluster_;
  std::vector<NodeIndex> order_;              // empty: synchronous
  std::vector<std::uint8_t> free_;            // [node]
  std::vector<double> inverse_root_;          // [node] 1 / sqrt(mass), 0 where fixed
  std::vector<Block> weight_;                 // [node] m by_force
  std::vector<double> along_, across_;        // [spring] kg: t^2 K + t D = along n n^T + across I
  std::vector<Block> diagonal_;               // [node] -A_k, or (I + A_k)^-1 with blocks
  std::vector<RigidProjection> projections_;  // [cluster]
  std::vector<std::uint8_t> done_;            // [cluster]
  std::vector<Vector3> members_;              // new outputs of a cluster's nodes
  double time_constant_ = 0.0;                // s
  std::vector<double> rates_;                 // [element] of enclosed volumes; empty: there are none
  Eigen::VectorXd old_;
};

}  // namespace springnet
