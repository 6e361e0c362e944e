// Shared by all update rules: the host, memory for outputs, the record of forces, and the evaluation that completes a
// step with the residual of its outputs.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <springnet/sdk/host.hpp>

#include "columns.hpp"
#include "step.hpp"

namespace springnet::recurrent {

void copy(const springnet_const_vectors& from, const springnet_vectors& to, std::uint32_t count) noexcept;

class Workspace {
 public:
  explicit Workspace(sdk::Host table) : host(table) {}

  // Call after every change of network.revision.
  void attach(const springnet_network& network);

  // Sets p* and v* of the step for its time constant; a_start must be known unless theta is 1.
  void set_free_motion(Step& step);
  // Provides the accelerations at the start of the step, those of the constrained motion at the committed state.
  // Evaluates them unless complete() did for the same `revision`.
  void know_start_acceleration(const Step& step);
  // Call before a commit: keeps the accelerations at its outputs, if evaluated, for the next start.
  void committed(const Step& step);

  // Forgets them, and the constraint forces: what was kept from the steps before.
  void forget() noexcept {
    known_.reset();
    forget_constraint_force();
  }

  // A state for outputs other than these two.
  [[nodiscard]] springnet_state& state_beside(const springnet_state* one,
                                              const springnet_state* other = nullptr) const {
    for (sdk::State& state : states_) {
      if (!state) state = host.make_state();
      if (state.get() != one && state.get() != other) return *state;
    }
    return *states_[0];  // not reached: there are three
  }
  // Outputs for a rule that changes them in place: the newest, or a copy of the start.
  springnet_state& outputs_in_place(Step& step) const;

  // A sweep from `read` to `write`; without order.
  [[nodiscard]] springnet_sweep sweep_call(const Step& step, const springnet_state& read, const springnet_state& write);
  // Forces and accelerations at `at`, at the end of the step, and the internal state of laws there.
  void evaluate(const Step& step, const springnet_state& at);
  // Forces and internal state of laws at the newest outputs, residual.
  void complete(Step& step);

  // Residual m ((U - v*) / h - theta a) - theta c of nodes that are not pinned, N; c: constraint forces of the last
  // sweep. Needs evaluate(). Sets free_acceleration().
  [[nodiscard]] Greatest residual(const Step& step, const springnet_state& at);
  // After it: sqrt(sum |residual|^2 / m), N kg^-1/2.
  [[nodiscard]] double residual_norm() const noexcept { return residual_norm_; }

  // The part of residual() that sets free_acceleration(), from the last evaluate().
  void free_accelerations(const Step& step) {
    if (step.constrained()) find_free_accelerations(step);
  }

  // Accelerations of the last evaluate(): of the constrained motion; and without constraints (after residual()).
  [[nodiscard]] const Columns& acceleration() const noexcept { return acceleration_; }
  [[nodiscard]] const Columns& free_acceleration() const noexcept { return free_acceleration_; }
  // Of the last evaluate(), of all nodes, without constraints.
  [[nodiscard]] const Columns& unconstrained() const noexcept { return unconstrained_; }
  // A node with spurious contact: held by a surface that it did not touch at the start, and that its start velocity and
  // force do not take it to. Diverging sweeps cause this. no_node: there is none.
  [[nodiscard]] std::uint32_t spurious_contact(const Step& step);
  // Constraint forces of the last sweep, N.
  [[nodiscard]] const Columns& constraint_force() const noexcept { return constraint_force_; }
  // Resets the constraint forces before the first sweep.
  void forget_constraint_force() noexcept;

  const sdk::Host host;
  ForceRecord record;

 private:
  void find_free_accelerations(const Step& step);

  mutable std::array<sdk::State, 3> states_;  // made when first used: a single sweep needs one
  Columns free_position_, free_velocity_;     // p*, v*; empty where theta is 1
  Columns start_acceleration_;                // m/s^2
  Columns acceleration_, free_acceleration_, constraint_force_;
  Columns unconstrained_;                // accelerations of the neurons by themselves, m/s^2
  std::vector<std::uint8_t> pinned_;     // [node_count] after residual(), 1: constrained in all coordinates
  std::vector<std::uint32_t> selected_;  // nodes
  // Revisions of the network and its loads for which start_acceleration_ was computed.
  using Revisions = std::pair<std::uint64_t, std::uint64_t>;
  [[nodiscard]] Revisions revisions(const Step& step) const { return {step.network.revision, host.load_revision()}; }
  std::optional<Revisions> known_;
  double residual_norm_ = 0.0;
};

}  // namespace springnet::recurrent
