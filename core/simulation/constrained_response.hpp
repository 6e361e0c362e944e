// How accelerations answer to changes of what they would be without constraints, with friction that follows the normal
// reactions.
//
// With the rows G of rigid connections and of surfaces that nodes slide on, W = 1/mass, and the columns
// D = G^T - B of what a unit multiplier exerts (B: friction mu t of a unit normal reaction, along the slip t),
//   a = a_free + W D x,  G a = c      so      da = P da_free,  P = I - W D (G W D)^-1 G.
// With the state, W D x changes at fixed multipliers by X dp + Y dv, and G a - c at fixed accelerations by rates r:
//   da = P (da_free + X dp + Y dv) - W D (G W D)^-1 (r_p dp + r_v dv).
// Of these, geometric stiffnesses of rigid connections and Y, of friction along the slip, are in the linearisation. P
// is not symmetric, not even in the norm of the masses: W D is not the normal of what G allows. A slip that begins at
// a node without rigid connections has t along the sliding acceleration, which turns with da_free; with rigid
// connections that direction counts as constant.
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include <Eigen/LU>

#include "constraints/acceleration_gradients.hpp"
#include "constraints/constraint_system.hpp"
#include "simulation/model.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {

class ConstrainedResponse {
 public:
  // At the state of `reactions`, at which model.constraints was linearised. Nodes whose reactions are needed are
  // evaluated; SPRINGNET_OK, or the status of a law that failed.
  springnet_status find(Model& model, ReactionsAt& reactions);
  void forget() noexcept { known_ = false; }
  [[nodiscard]] bool known() const noexcept { return known_; }
  // values = P values, or P^T values; [3 node], x of all nodes first. 0 for nodes that are fixed or held.
  void apply(bool transposed, double* values);
  // For derivatives with respect to the state, [3 node] each. Before apply(): change += X dp; after it:
  // change -= W D (G W D)^-1 (r_p dp + r_v dv).
  void add_forces(const double* dp, double* change) const;
  void add_rates(const double* dp, const double* dv, double* change);
  // The same transposed, of weights: before apply(true, …), and of its answer.
  void add_rates_transposed(const double* weights, double* by_position, double* by_velocity);
  void add_forces_transposed(const double* weights, double* by_position) const;
  // Whether friction acts on nodes without rigid connections that slide; takes out of forces, N, what surfaces balance
  // of those on them, with the friction that this causes; [node][3].
  [[nodiscard]] bool has_friction() const noexcept { return has_friction_; }
  // Calls use(node, P) for nodes without rigid connections on surfaces, in ascending order, with directions of slips
  // that begin as they are.
  template <class Use>
  void for_each_lone(const Use& use) const {
    for (const Lone& each : lone_) use(each.node, each.straight_response);
  }
  void take_reactions(double* forces) const;
  // What constraints add to the acceleration of a node that can move, m/s^2; 0 where it has no rows.
  [[nodiscard]] const Vector3& added(std::uint32_t node) const { return added_[node]; }

 private:
  struct Lone {  // a node without rigid connections, on surfaces
    std::uint32_t node;
    Matrix3 response, straight_response;  // without the turn of a slip that begins: a projection
    Matrix3 by_position, by_velocity;     // P X - D (G D)^-1 r
  };
  struct FrictionColumn {  // of the rows of clusters
    Eigen::Index row;
    std::uint32_t node;
    Vector3 force;  // mu t
  };
  struct OwnForce {  // X of a node with rigid connections on surfaces
    std::uint32_t node;
    Matrix3 by_position;
  };
  class OnSurfaces;
  void find_lone(const ReactionsAt& reactions, std::uint32_t node, const Vector3& free, const Vector3& constrained);
  void find_rates(const ReactionsAt& reactions);
  void find_clusters(const ReactionsAt& reactions);
  void factorise();
  void apply_clusters(bool transposed, double* values) const;
  // The multipliers x of (G W D) x = right_side, or of its transpose.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& right_side) const;
  [[nodiscard]] Eigen::VectorXd solve_transposed(const double* weights) const;
  template <class Add>
  void for_each_change(const Eigen::VectorXd& multipliers, const Add& add) const;

  bool known_ = false, has_friction_ = false;
  const Model* model_ = nullptr;
  std::vector<Vector3> added_;  // [node]
  std::vector<Lone> lone_;
  std::vector<OwnForce> own_forces_;
  std::set<std::uint32_t> paired_;           // nodes that other bodies push
  std::vector<ConstraintRow> rows_;          // of clusters, of pairs of bodies, and of surfaces on paired_
  std::vector<AccelerationGradient> rates_;  // of these: r_p and r_v of the first node, minus those of the second
  std::vector<FrictionColumn> friction_;
  bool factorised_ = false;  // what follows; not before it is needed
  ConstraintSystem system_;  // G W G^T
  // G W D = G W G^T - U E^T, with U = G W B of the friction columns and E their rows.
  Eigen::MatrixXd solved_;                      // (G W G^T)^-1 U
  Eigen::PartialPivLU<Eigen::MatrixXd> small_;  // I - E^T (G W G^T)^-1 U
};

}  // namespace springnet
