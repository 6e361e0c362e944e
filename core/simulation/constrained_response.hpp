// How accelerations answer to changes of what they would be without constraints, with friction that follows the normal
// reactions.
//
// With the rows G of rigid connections and of surfaces that nodes slide on, W = 1/mass, and the columns
// D = G^T - B of what a unit multiplier exerts (B: friction mu t of a unit normal reaction, along the slip t),
//   a = a_free + W D x,  G a = c      so      da = P da_free,  P = I - W D (G W D)^-1 G.
// P is not symmetric, not even in the norm of the masses: W D is not the normal of what G allows. A slip that begins at
// a node without rigid connections has t along the sliding acceleration, which turns with da_free; with rigid
// connections that direction counts as constant.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/LU>

#include "constraints/constraint_system.hpp"
#include "simulation/model.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {

class ConstrainedResponse {
 public:
  // Whether friction acts on any node of these rows, so that P is not the projection of ConstraintSet.
  [[nodiscard]] static bool has_friction(const Model& model);
  // At the state of `reactions`, at which model.constraints was linearised. Nodes whose reactions are needed are
  // evaluated; SPRINGNET_OK, or the status of a law that failed.
  springnet_status find(Model& model, ReactionsAt& reactions);
  void forget() noexcept { known_ = false; }
  [[nodiscard]] bool known() const noexcept { return known_; }
  // values = P values, or P^T values; [3 node], x of all nodes first. 0 for nodes that are fixed or held.
  void apply(bool transposed, double* values);
  // What constraints add to the acceleration of a node that can move, m/s^2; 0 where it has no rows.
  [[nodiscard]] const Vector3& added(std::uint32_t node) const { return added_[node]; }

 private:
  struct Lone {  // a node without rigid connections, on surfaces
    std::uint32_t node;
    Matrix3 response;
  };
  struct FrictionColumn {  // of the rows of clusters
    Eigen::Index row;
    std::uint32_t node;
    Vector3 force;  // mu t
  };
  [[nodiscard]] Matrix3 response_of(const Model& model, const ReactionsAt& reactions, std::uint32_t node,
                                    const Vector3& free) const;
  void find_clusters(const ReactionsAt& reactions);
  void factorise();
  void apply_clusters(bool transposed, double* values) const;

  bool known_ = false;
  const Model* model_ = nullptr;
  std::vector<Vector3> added_;  // [node]
  std::vector<Lone> lone_;
  std::vector<ConstraintRow> rows_;  // of clusters
  std::vector<FrictionColumn> friction_;
  bool factorised_ = false;  // what follows; not before it is needed
  ConstraintSystem system_;  // G W G^T
  // G W D = G W G^T - U E^T, with U = G W B of the friction columns and E their rows.
  Eigen::MatrixXd solved_;                      // (G W G^T)^-1 U
  Eigen::PartialPivLU<Eigen::MatrixXd> small_;  // I - E^T (G W G^T)^-1 U
};

}  // namespace springnet
