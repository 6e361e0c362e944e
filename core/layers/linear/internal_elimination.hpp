// Internal states eliminated from the linear system of an implicit method: element by element, dz follows dp and dv.
#pragma once

#include <cstddef>
#include <vector>

#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// With w the weight, for each element dz = (I - w dr/dz)^-1 (right side + w (dr/dq dq + dr/dq' dq')).
class InternalElimination {
 public:
  InternalElimination(const Layout& layout, InstructionSet set) : layout_(layout), set_(set) {}

  // Sets `view` so that evaluations with derivatives at this state fill the elimination.
  void begin(const NodeArrays& nodes, double weight, InternalView& view);
  [[nodiscard]] bool known() const noexcept { return weight_ > 0.0; }
  void forget() noexcept { weight_ = 0.0; }

  // dp, dv: [3 node], x of all nodes first; null: 0. change: dz, [internal_count].
  void change(const double* right_side, const double* dp, const double* dv, double* change);
  // Adds the forces of dz on nodes, N, to [3 node] numbers, x of all nodes first.
  void add_forces(const double* change, double* force) const;

 private:
  // Directional derivatives of invariants and rates, in the places of the laws' first states.
  void differentiate(const double* dp, const double* dv);
  [[nodiscard]] NodeArrays nodes_at(const std::vector<double>& state) const noexcept;

  const Layout& layout_;
  InstructionSet set_;
  double weight_ = 0.0;        // s; 0: not known
  std::vector<double> state_;  // [6 node]
  EliminationRecord record_;
  std::vector<double> shifted_, q_[2], rate_[2];
};

}  // namespace springnet::layers
