// What an integrator may do against the rules of plugin.h.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include <springnet/sdk/host.hpp>

namespace springnet::testing {

// What an integrator can use while it misbehaves.
struct StepContext {
  const springnet_host* host;
  void* context;
  double from, until;
  springnet_state* state;  // the committed one, advanced by explicit Euler: valid to commit at `until`
  springnet_step_report* report;

  [[nodiscard]] std::uint32_t nodes() const { return host->network(context)->node_count; }
  [[nodiscard]] springnet_evaluation at() const { return sdk::evaluation_at(until, *state); }
  // A search for touches in the whole step, whose states are nan.
  [[nodiscard]] springnet_impact_search search() const {
    auto search = sdk::sized<springnet_impact_search>();
    search.step_from = search.from = from;
    search.step_until = search.until = until;
    search.user = const_cast<StepContext*>(this);
    search.state_at = [](void* user, double, springnet_vectors position,
                         springnet_vectors velocity) -> springnet_status {
      for (const springnet_vectors& each : {position, velocity})
        for (double* axis : {each.x, each.y, each.z})
          std::fill_n(axis, static_cast<const StepContext*>(user)->nodes(), std::numeric_limits<double>::quiet_NaN());
      return SPRINGNET_OK;
    };
    return search;
  }
  // A valid sweep, all nodes at once: a second state takes the outputs.
  [[nodiscard]] springnet_sweep sweep(springnet_state& next) const {
    auto sweep = sdk::sized<springnet_sweep>();
    sweep.time = until;
    sweep.time_constant = until - from;
    sweep.start_position = sweep.position = sdk::view(state->position);
    sweep.start_velocity = sweep.velocity = sdk::view(state->velocity);
    sweep.next_position = next.position;
    sweep.next_velocity = next.velocity;
    sweep.force = next.force;
    sweep.user = const_cast<StepContext*>(this);
    sweep.update = [](void*, const springnet_node_batch*) {};
    return sweep;
  }
  // The same node by node, in place.
  [[nodiscard]] springnet_sweep sweep_in(const std::vector<std::uint32_t>& order) const {
    springnet_sweep ordered = sweep(*state);
    ordered.order = order.data();
    ordered.order_count = static_cast<std::uint32_t>(order.size());
    return ordered;
  }
};

using Misdeed = std::function<springnet_status(const StepContext&)>;
struct Case {
  const char* name;
  Misdeed misdeed;
  // It breaks the rules, so that its status alone must end the run with an error of the plugin.
  bool refused = true;
  // Its only fault is that the step ends before its time: nothing may follow.
  bool incomplete = false;
};

std::vector<Case> all_cases();

}  // namespace springnet::testing
