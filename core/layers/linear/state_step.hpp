// Derivatives by the internal states of laws, and of these: of a step of the states, or at a state alone. The recurrent
// network eliminates states from a step; this is what else its derivative has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// For each law with states of a spring or element, with q its invariant and u the rate of that, Q its force, z its
// states; those at the start of the step with index 0, those at its end Z:
//   dQ = Q_z dz0 + Q_q0 dq0 + Q_u0 du0   (Q_q dq + Q_u du is in the linearisation)
//   dZ = Z_q dq + Z_u du + Z_z dz0 + Z_q0 dq0 + Z_u0 du0
// At a state alone: dQ = Q_z dz. Arrays over the nodes have 3n numbers, x of all nodes first; arrays over the states
// internal_count, in which q and u are in the place of each law's first state. Of what has been removed states stay.
class StateStep {
 public:
  StateStep(const Layout& layout, InstructionSet set) : layout_(layout), set_(set) {}

  // Evaluates the laws: nodes.internal with a time step, nodes at its end; or without, at a state. Throws Error(plugin)
  // if a law does not give these derivatives.
  springnet_status find(double time, const NodeArrays& nodes, springnet_message& message);

  // Of a state of the nodes.
  void invariants(const NodeArrays& nodes, const double* dp, const double* dv, double* q, double* u) const;
  // by_position and by_velocity += what weights q and u of the invariants are of them.
  void weigh_invariants(const NodeArrays& nodes, const double* q, const double* u, double* by_position,
                        double* by_velocity) const;

  // force += dQ on the nodes of find(), N; next = Z_z dz0 + …, both by the start. q0, u0: null at a state alone.
  void from_start(const NodeArrays& nodes, const double* z0, const double* q0, const double* u0, double* force,
                  double* next) const;
  // next += Z_q q + Z_u u.
  void from_end(const double* q, const double* u, double* next) const;
  // The same transposed, for weights of forces on nodes and of the states at the end: z0, q0, u0 += …; q, u = ….
  void weigh_start(const NodeArrays& nodes, const double* force, const double* next, double* z0, double* q0,
                   double* u0) const;
  void weigh_end(const double* next, double* q, double* u) const;

 private:
  class Wanted;
  springnet_status find_springs(std::size_t group, double time, const NodeArrays& nodes, springnet_message& message);
  // q: derivatives of what depends on the invariant's place, Z_q … ; first: of the law's first state.
  template <class Use>
  void for_each(const Use& use) const;

  const Layout& layout_;
  InstructionSet set_;
  bool steps_ = false;
  std::vector<double> force_by_state_, next_by_q_, next_by_u_, next_by_start_q_, next_by_start_u_;  // [internal]
  std::vector<double> force_by_start_q_, force_by_start_u_;  // [internal], in the place of the first state
  std::vector<double> next_by_state_;                        // [internal][max_states]
};

}  // namespace springnet::layers
