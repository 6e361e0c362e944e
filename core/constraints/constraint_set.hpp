// Everything that restricts nodes, behind one face: fixation and prescribed motion, surfaces, rigid connections.
// Sweeps, events, implicit methods, reactions and outputs ask it what a state may be, how it may change and what forces
// see to that. Which contacts there are is contact()'s to say, what hangs together rigidly rigid()'s.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

#include "constraints/constraint_system.hpp"
#include "constraints/contact.hpp"
#include "constraints/rigid.hpp"

namespace springnet {

class ConstraintSet {
 public:
  // `mass` (kg, [engine's node]) and the numberings have to outlive it.
  ConstraintSet(const Network& network, const std::vector<std::uint32_t>& user_number,
                const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass);
  ConstraintSet(const ConstraintSet&) = delete;
  ConstraintSet& operator=(const ConstraintSet&) = delete;

  [[nodiscard]] Contact& contact() noexcept { return contact_; }
  [[nodiscard]] const Contact& contact() const noexcept { return contact_; }
  [[nodiscard]] const RigidConnections& rigid() const noexcept { return rigid_; }

  // ---- states ----
  // Puts nodes that do not move by themselves where they are: fixed ones stay as in `start` (m, a state of before),
  // prescribed ones follow their motion, those that stick are carried along from `start` by their surface.
  void place(const Placement& at, const springnet_const_vectors& start, const springnet_vectors& position,
             const springnet_vectors& velocity) const;
  // The same of a state that a solver arrived at, in which sticking nodes are where they are but for its rounding.
  void correct(const Placement& at, const springnet_const_vectors& start, const springnet_vectors& position,
               const springnet_vectors& velocity) const;
  // Puts positions, then velocities, of all other nodes where connections and surfaces allow, weighted with the masses.
  // Nodes that were just `stopped` by a surface may still move along it; those of `rebounds` begin on their surfaces,
  // where lengths let them. SPRINGNET_RECOVERABLE and a message if lengths cannot be kept.
  springnet_status project(const Placement& at, const springnet_vectors& position, const springnet_vectors& velocity,
                           springnet_message& message, const std::vector<std::uint32_t>& stopped = {},
                           const Rebounds& rebounds = {}) const;

  // ---- accelerations and forces ----
  // Takes out of accelerations (m/s^2, arrays from node `first`) of nodes [first, first + count) what fixation and
  // surfaces do not allow, and puts in friction. Nodes that slide with rigid connections are left to those.
  void accelerate(const Placement& at, std::uint32_t first, std::uint32_t count,
                  const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                  double* const acceleration[3]) const;
  // Then what rigid connections do not allow, of all clusters.
  void accelerate_clusters(const Placement& at, const springnet_const_vectors& position,
                           const springnet_const_vectors& velocity, const springnet_vectors& acceleration) const;
  // What fixation and surfaces do to a node whose acceleration would be `free` and is `bound`, m/s^2; N. `tension`:
  // [rod] N, not read of a node without rigid connections.
  [[nodiscard]] Vector3 reaction(std::uint32_t node, const Vector3& free, const Vector3& bound,
                                 const springnet_const_vectors& position, const double* tension) const;
  // The part of a node's reaction (N) that is one surface's: normal forces as they make it up, and friction in
  // proportion to what each can bear.
  [[nodiscard]] Vector3 share_of(const Placement& at, std::uint32_t node, std::size_t surface, const Vector3& position,
                                 const Vector3& reaction) const;

  // Of friction of a node on an obstacle; infinite where the obstacle holds it.
  [[nodiscard]] double coefficient(std::uint32_t node, std::size_t obstacle) const;

  // ---- within a step ----
  // Outputs of nodes [first, first + count) without rigid connections, see Contact::constrain.
  void constrain(const Placement& end, std::uint32_t first, std::uint32_t count, const springnet_sweep& sweep,
                 const Vector3* read = nullptr);
  // Those of one cluster, and of all, by up to `threads` threads.
  springnet_status constrain_cluster(const Placement& end, std::size_t cluster, const springnet_sweep& sweep,
                                     springnet_message& message) const;
  springnet_status constrain_clusters(const Placement& end, const springnet_sweep& sweep, unsigned threads,
                                      springnet_message& message) const;

  // ---- small changes of a state ----
  // Remembers the directions in which motion is bound at these positions: rods first, then surfaces that nodes slide
  // on.
  void linearise(const Placement& at, const springnet_const_vectors& position);
  [[nodiscard]] const std::vector<ConstraintRow>& rows() const noexcept { return rows_; }
  // The derivative of the force of a rod by the position of its first end, N/m: it turns with the rod, like a spring of
  // that tension (N) without stiffness of its own. How the tension changes is the multipliers' business.
  [[nodiscard]] Matrix3 turning_of(std::size_t rod, const springnet_const_vectors& position, double tension) const;
  // Whether friction along a row of a surface follows the slip, and then the derivative of the node's acceleration by
  // its velocity, 1/s, from its reaction, N. How normal forces change is left out.
  [[nodiscard]] bool friction_follows_slip(const ConstraintRow& row) const;
  [[nodiscard]] Matrix3 friction_of(const Placement& at, const ConstraintRow& row,
                                    const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                                    const Vector3& reaction) const;
  // The nearest change of velocities ([3 node], by components) that the rows allow, weighted with the inverse of
  // `mobility` ([node] 3x3, row by row; null: 1/mass).
  void project_change(const double* mobility, double* values);

 private:
  [[nodiscard]] bool is_lone(std::uint32_t node) const noexcept;  // without rigid connections
  void place_fixed(const Placement& at, std::uint32_t node, const springnet_const_vectors& start,
                   const springnet_vectors& position, const springnet_vectors& velocity) const;

  const std::vector<double>& mass_;
  Contact contact_;
  RigidConnections rigid_;
  std::vector<ConstraintRow> rows_;
  bool factorised_ = false;
  std::vector<double> mobility_;  // that system_ was factorised with; empty: 1/mass
  ConstraintSystem system_;
};

}  // namespace springnet
