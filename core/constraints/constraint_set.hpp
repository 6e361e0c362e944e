// All constraints on nodes behind one interface: fixed nodes, prescribed motion, contact with obstacles, rigid
// connections. Answers which states and changes of state the constraints allow, and what forces they exert. contact()
// holds the contact state, rigid() the clusters of rigidly connected nodes.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

#include "constraints/body_contacts.hpp"
#include "constraints/body_pushes.hpp"
#include "constraints/constraint_system.hpp"
#include "constraints/contact.hpp"
#include "constraints/pair_motion.hpp"
#include "constraints/rigid.hpp"
#include "layers/linear/projection.hpp"

namespace springnet {

class ConstraintSet {
 public:
  // `mass` (kg, [engine's node]) and the numberings must outlive the set.
  ConstraintSet(const Network& network, const std::vector<std::uint32_t>& user_number,
                const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass);
  ConstraintSet(const ConstraintSet&) = delete;
  ConstraintSet& operator=(const ConstraintSet&) = delete;

  [[nodiscard]] Contact& contact() noexcept { return contact_; }
  [[nodiscard]] const Contact& contact() const noexcept { return contact_; }
  [[nodiscard]] const RigidConnections& rigid() const noexcept { return rigid_; }
  [[nodiscard]] BodyContacts& bodies() noexcept { return bodies_; }
  [[nodiscard]] const BodyContacts& bodies() const noexcept { return bodies_; }
  [[nodiscard]] BodyPushes& pushes() noexcept { return pushes_; }
  [[nodiscard]] const BodyPushes& pushes() const noexcept { return pushes_; }

  // ---- states ----
  // Sets positions and velocities of fixed, prescribed and sticking nodes: fixed ones stay as in `start` (m, an earlier
  // state), prescribed ones follow their motion, sticking ones are carried from `start` by their surface.
  void place(const Placement& at, const springnet_const_vectors& start, const springnet_vectors& position,
             const springnet_vectors& velocity) const;
  // The same for a solver's state, whose sticking nodes are in place up to rounding.
  void correct(const Placement& at, const springnet_const_vectors& start, const springnet_vectors& position,
               const springnet_vectors& velocity) const;
  // Projects positions, then velocities, of all other nodes onto connections and surfaces, weighted with the masses.
  // Nodes just `stopped` by a surface may still move along it; those of `rebounds` start on their surfaces if the
  // lengths allow. SPRINGNET_RECOVERABLE and a message if lengths cannot be kept.
  springnet_status project(const Placement& at, const springnet_vectors& position, const springnet_vectors& velocity,
                           springnet_message& message, const std::vector<std::uint32_t>& stopped = {},
                           const Rebounds& rebounds = {}) const;
  // Part of that. Where events are located: gaps of bodies that touch become zero, and rates, too.
  void project_pairs(const Placement& at, const springnet_vectors& position, const springnet_vectors& velocity) const;

  // ---- accelerations and forces ----
  // Constrains accelerations (m/s^2, arrays from node `first`) of nodes [first, first + count) by fixation and
  // surfaces, and adds friction. Leaves out sliding nodes with rigid connections: see accelerate_clusters().
  void accelerate(const Placement& at, std::uint32_t first, std::uint32_t count,
                  const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                  double* const acceleration[3]) const;
  // Then constrains those of all clusters by their rigid connections.
  void accelerate_clusters(const Placement& at, const springnet_const_vectors& position,
                           const springnet_const_vectors& velocity, const springnet_vectors& acceleration) const;
  // Force (N) of fixation and surfaces on a node whose acceleration is `bound` and would be `free` without constraints,
  // m/s^2. `tension`: [rod] N, not read for a node without rigid connections.
  [[nodiscard]] Vector3 reaction(std::uint32_t node, const Vector3& free, const Vector3& bound,
                                 const springnet_const_vectors& position, const double* tension) const;
  // One surface's share of a node's reaction (N): its normal force, and friction in proportion to each surface's limit.
  [[nodiscard]] Vector3 share_of(const Placement& at, std::uint32_t node, std::size_t surface, const Vector3& position,
                                 const Vector3& reaction) const;

  // Of friction of a node on an obstacle; infinite where the obstacle holds it.
  [[nodiscard]] double coefficient(std::uint32_t node, std::size_t obstacle) const;

  // ---- within a step ----
  // Around a sweep that constrains all nodes at once: see Contact.
  void remember_contacts(const springnet_sweep& sweep) { contact_.remember(sweep); }
  void limit_changes(const Placement& end, const springnet_sweep& sweep) {
    contact_.limit_changes(end, sweep, rigid_.cluster_of());
  }
  // Before what follows: bodies that touch push outputs of nodes [first, first + count).
  void push(std::uint32_t first, std::uint32_t count, const springnet_sweep& sweep) const {
    for (std::uint32_t k = first; pushes_.count() > 0 && k < first + count; ++k) pushes_.apply(k, sweep, mass_[k]);
  }
  void push(std::span<const std::uint32_t> nodes, const springnet_sweep& sweep) const {
    if (pushes_.count() > 0)
      for (const std::uint32_t k : nodes) pushes_.apply(k, sweep, mass_[k]);
  }
  // Constrains outputs of nodes [first, first + count) without rigid connections, see Contact::constrain.
  void constrain(const Placement& end, std::uint32_t first, std::uint32_t count, const springnet_sweep& sweep,
                 const Vector3* read = nullptr);
  // The same for nodes of a list, none of which has rigid connections. read: [component][i] velocity that the update of
  // nodes[i] started from, m/s.
  void constrain(const Placement& end, std::span<const std::uint32_t> nodes, const springnet_sweep& sweep,
                 const springnet_const_vectors& read);
  // The same for one cluster, and for all with up to `threads` threads.
  springnet_status constrain_cluster(const Placement& end, std::size_t cluster, const springnet_sweep& sweep,
                                     springnet_message& message) const;
  springnet_status constrain_clusters(const Placement& end, const springnet_sweep& sweep, unsigned threads,
                                      springnet_message& message) const;

  // ---- small changes of a state ----
  // Stores the constraint rows at these positions: rods first, then the surfaces on which nodes slide, then pairs of
  // bodies that press on each other: as they were in the last sweep or, where events are located, as they are.
  void linearise(const Placement& at, const springnet_const_vectors& position);
  [[nodiscard]] const std::vector<ConstraintRow>& rows() const noexcept { return linearised_.rows; }
  // What linearise() stored, so that it can be set aside and put back.
  struct Linearised {
    std::vector<ConstraintRow> rows;
    bool factorised = false;
    std::vector<double> mobility;  // with which the system was factorised; empty: 1/mass
    ConstraintSystem system;
  };
  void exchange(Linearised& other) { std::swap(linearised_, other); }
  // The smallest change of velocities ([3 node], by components; weighted with the masses) that gives the rows, as they
  // are now, these rates, m/s.
  void add_rates(const std::function<double(const ConstraintRow&)>& rate, double* values);
  // Geometric stiffness of a rod at this tension (N), N/m: minus the derivative of its force on the first end with
  // respect to that end's position, at constant tension. The multipliers carry changes of the tension.
  [[nodiscard]] Matrix3 rod_geometric_stiffness(std::size_t rod, const springnet_const_vectors& position,
                                                double tension) const;
  // Whether friction of a surface's row follows the slip; and if so, the derivative of the node's acceleration with
  // respect to its velocity, 1/s, from its reaction, N. Neglects changes of the normal force.
  [[nodiscard]] bool friction_follows_slip(const ConstraintRow& row) const;
  [[nodiscard]] Matrix3 friction_derivative(const Placement& at, const ConstraintRow& row,
                                            const springnet_const_vectors& position,
                                            const springnet_const_vectors& velocity, const Vector3& reaction) const;
  // Projects a change of velocities ([3 node], by components) onto those that the rows allow, in the norm of the
  // inverse of `mobility` ([node] 3x3, row by row; null: 1/mass).
  // transposed: by the transposed projection, of weights of such changes.
  void project_change(const double* mobility, double* values, bool transposed = false);
  // The same with the rows as they are now, kept for many changes ([node][3]). mobility: [node] 3x3, symmetric, which
  // must outlive it.
  [[nodiscard]] layers::Projection projection(const std::vector<double>& mobility) const;

 private:
  [[nodiscard]] bool is_lone(std::uint32_t node) const noexcept;  // without rigid connections
  void place_fixed(const Placement& at, std::uint32_t node, const springnet_const_vectors& start,
                   const springnet_vectors& position, const springnet_vectors& velocity) const;
  // Of bodies_.touching(), in this order.
  [[nodiscard]] std::vector<PairMotion> pairs_at(const springnet_const_vectors& position,
                                                 const springnet_const_vectors& velocity) const;
  // Along the normals; with_sticking: and across, of those that stick.
  [[nodiscard]] std::vector<ConstraintRow> rows_of(const std::vector<PairMotion>& pairs, bool with_sticking) const;

  const std::vector<double>& mass_;
  Contact contact_;
  RigidConnections rigid_;
  BodyContacts bodies_;
  BodyPushes pushes_;  // of the step's sweeps
  Linearised linearised_;
};

}  // namespace springnet
