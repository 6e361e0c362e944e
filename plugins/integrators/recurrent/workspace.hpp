// What all update rules share: the host, memory for outputs, the record of forces, and the evaluation that completes a
// step and tells how far its outputs are from the equation of motion.
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
  explicit Workspace(sdk::Host table)
      : host(table), states_{table.make_state(), table.make_state(), table.make_state()} {}

  // Has to be called after every change of network.revision.
  void attach(const springnet_network& network);

  // Sets p* and v* of the step for its time constant; a_start must be known unless theta is 1.
  void set_free_motion(Step& step);
  // The accelerations at the start of steps: those of the constrained motion at the committed state. They are evaluated
  // where `revision` is not that of the last evaluation, which complete() did.
  void know_start_acceleration(const Step& step);
  // Before a commit: the accelerations at its outputs are those at the next start, if they were evaluated.
  void committed(const Step& step);

  // One of the states for outputs that is neither of these.
  [[nodiscard]] springnet_state& state_beside(const springnet_state* one,
                                              const springnet_state* other = nullptr) const noexcept {
    for (const sdk::State& state : states_) {
      if (state.get() != one && state.get() != other) return *state;
    }
    return *states_[0];  // not reached: there are three
  }
  // Outputs that a rule changes in place: those there are, or a copy of the start.
  springnet_state& outputs_in_place(Step& step) const noexcept;

  // A sweep from `read` to `write`; without order.
  [[nodiscard]] springnet_sweep sweep_call(const Step& step, const springnet_state& read, const springnet_state& write);
  // Forces and accelerations at `at`, at the end of the step.
  void evaluate(const Step& step, const springnet_state& at);
  // Forces at the newest outputs, internal state of laws, residual.
  void complete(Step& step);

  // m ((U - v*) / h - theta a) - theta c over the nodes that nothing holds, N; c: what rigid connections, surfaces and
  // friction did in the last sweep. Needs evaluate(). Leaves the free accelerations in free_acceleration().
  [[nodiscard]] Greatest residual(const Step& step, const springnet_state& at);

  // The part of residual() that finds free_acceleration() and stays().
  void free_accelerations(const Step& step, const springnet_state& at) {
    if (step.constrained()) find_free_accelerations(step, at);
  }

  // Of the last evaluate(): of the constrained motion; as if nothing held the nodes (after residual()).
  [[nodiscard]] const Columns& acceleration() const noexcept { return acceleration_; }
  [[nodiscard]] const Columns& free_acceleration() const noexcept { return free_acceleration_; }
  // A node that a surface holds now and did not at the start, though neither its velocity nor the force on it then
  // take it there: sweeps that diverge throw nodes about until they hit something. no_node: there is none.
  [[nodiscard]] std::uint32_t thrown_node(const Step& step);
  // Of the last sweep, N.
  [[nodiscard]] const Columns& constraint_force() const noexcept { return constraint_force_; }
  // Before the first sweep there is none.
  void forget_constraint_force() noexcept;
  // After residual(): 1 where something holds the node at all its coordinates.
  [[nodiscard]] const std::vector<std::uint8_t>& stays() const noexcept { return stays_; }

  const sdk::Host host;
  ForceRecord record;

 private:
  void find_free_accelerations(const Step& step, const springnet_state& at);

  std::array<sdk::State, 3> states_;
  Columns free_position_, free_velocity_;  // p*, v*; empty where theta is 1
  Columns start_acceleration_;             // m/s^2
  Columns acceleration_, free_acceleration_, constraint_force_;
  std::vector<std::uint8_t> stays_;    // [node_count]
  std::vector<std::uint32_t> some_;    // nodes
  std::vector<double> internal_rate_;  // [internal_count]
  // Revisions of the network and its loads that start_acceleration_ belongs to.
  using Revisions = std::pair<std::uint64_t, std::uint64_t>;
  [[nodiscard]] Revisions revisions(const Step& step) const { return {step.network.revision, host.load_revision()}; }
  std::optional<Revisions> known_;
  double evaluations_ = 0.0;  // besides the sweeps
};

}  // namespace springnet::recurrent
