// One time step on its way.
#pragma once

#include <cstdint>
#include <limits>

#include <springnet/sdk/host.hpp>

#include "node_update.hpp"

namespace springnet::recurrent {

// With h the time constant and the weight w = theta h, the outputs of every node that moves freely obey
//
//   U = v* + w a(P, U),   v* = v + (1 - theta) h a_start
//   P = p* + w U,         p* = p + (1 - theta) h v
//
// at the fixed point, whatever the update rule: theta = 1 is the backward Euler step, 1/2 the trapezoidal rule.
struct Step {
  double from;           // s
  double until;          // s
  double time_constant;  // s: until - from, or a stage on the way to it
  double theta;          // 1
  double tolerance;      // N
  const springnet_state& start;
  const springnet_network& network;
  bool compares;        // forces of successive sweeps are compared; a single synchronous sweep has nothing to compare
  bool decides = true;  // which nodes touch, slide and stick; else that stays as committed
  bool waits = false;   // sweeps do not decide yet: outputs are far from the solution
  bool is_linear = false;    // outputs are small changes of the linearised network
  bool keeps_order = false;  // sweeps in an order keep that of the first one: all are the same map
  double relaxation = 1.0;   // share of its way that a node goes in a sweep of `wavefront` which is accelerated
  double rounding = 0.0;     // N, of the forces (force_rounding.hpp); 0: not known

  springnet_const_vectors free_position{}, free_velocity{};  // p*, v*: where nodes go that nothing accelerates
  springnet_state* outputs = nullptr;                        // the newest; null: the start
  bool evaluated = false;                                    // Workspace::complete() was done for them
  ForceRecord::Differences differences{};                    // of the last sweep
  std::uint64_t sweeps = 0;                                  // of this attempt
  std::uint32_t start_node = no_node;
  bool finite = true;
  double residual = std::numeric_limits<double>::quiet_NaN();  // N
  // sqrt(sum m |r|^2) of the residual r = U - v* - w a, kg^1/2 m/s, where `evaluated`; and the reduction of it by the
  // last sweep, if the rule knows that.
  double norm = std::numeric_limits<double>::quiet_NaN(), rate = std::numeric_limits<double>::quiet_NaN();
  bool is_provisional = false;    // outputs are only where a search begins: not for a state, whatever the time
  bool has_begun_again = false;   // a sweep has, from the start: forces before it tell nothing
  bool residual_decides = false;  // the residual alone, which the rule has set, tells whether the step has settled
  mutable springnet_internal internal{};

  [[nodiscard]] double weight() const noexcept { return theta * time_constant; }
  [[nodiscard]] const springnet_state& newest() const noexcept { return outputs == nullptr ? start : *outputs; }
  // How laws step their internal state to the outputs: within each evaluation, as part of the fixed point. `next`:
  // where that at the end goes. Null if no law has any; valid until the next call.
  [[nodiscard]] const springnet_internal* internal_step(double* next = nullptr) const noexcept {
    if (network.internal_count == 0) return nullptr;
    internal = {sizeof internal, theta < 1.0 ? 2u : 1u, time_constant, nullptr, next, nullptr};
    return &internal;
  }
  // At the outputs, or at another state, at the end of the step.
  [[nodiscard]] springnet_evaluation evaluation_at_end(const springnet_state& at) const noexcept {
    springnet_evaluation evaluation = sdk::evaluation_at(until, at);
    evaluation.internal = internal_step();
    return evaluation;
  }
  // Whether anything but fixation acts on outputs after their update, as far as the sweeps know; and whether anything
  // may, in a sweep to come.
  [[nodiscard]] bool constrained() const noexcept {
    return network.surface_count > 0 || network.rigid_count > 0 || is_pushed();
  }
  [[nodiscard]] bool may_be_constrained() const noexcept { return constrained() || network.body_contact_count > 0; }
  // By other bodies: any node, or one.
  [[nodiscard]] bool is_pushed() const noexcept { return network.body_contact_count > 0 && *network.pushed_count > 0; }
  [[nodiscard]] bool is_pushed(std::size_t node) const noexcept { return is_pushed() && network.pushed[node] != 0; }
};

}  // namespace springnet::recurrent
