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

  [[nodiscard]] const springnet_network& network() const {
    auto query = sdk::sized<springnet_network_query>();
    host->network(context, &query);
    return *query.network;
  }
  [[nodiscard]] std::uint32_t nodes() const { return network().node_count; }

  // The functions of the host with their arguments put into requests. Null: there was none.
  [[nodiscard]] springnet_state* create_state() const {
    auto creation = sdk::sized<springnet_state_creation>();
    return host->create_state(context, &creation) == SPRINGNET_OK ? creation.state : nullptr;
  }
  springnet_status destroy_state(springnet_state* any) const { return host->destroy_state(context, any); }
  const springnet_state* committed(double* time) const {
    auto answer = sdk::sized<springnet_committed>();
    if (host->committed(context, &answer) != SPRINGNET_OK) return nullptr;
    *time = answer.time;
    return answer.state;
  }
  [[nodiscard]] springnet_status begin(double begin, double end) const {
    auto interval = sdk::sized<springnet_interval>();
    interval.from = begin;
    interval.until = end;
    return host->begin(context, &interval);
  }
  [[nodiscard]] springnet_status commit(double time, springnet_state* any) const {
    auto commitment = sdk::sized<springnet_commitment>();
    commitment.time = time;
    commitment.state = any;
    return host->commit(context, &commitment);
  }
  [[nodiscard]] springnet_status evaluate_nodes(springnet_evaluation at, const std::uint32_t* some,
                                                std::uint32_t count) const {
    at.nodes = some;
    at.node_count = count;
    return host->evaluate(context, &at);
  }
  [[nodiscard]] springnet_status linearise(const springnet_evaluation* at, double elimination = 0.0) const {
    auto request = sdk::sized<springnet_linearisation>();
    request.at = at;
    request.elimination = elimination;
    return host->linearise(context, &request);
  }
  [[nodiscard]] springnet_status jacobian_times(const double* dp, const double* dv, double* out) const {
    auto product = sdk::sized<springnet_jacobian_product>();
    product.dp = dp;
    product.dv = dv;
    product.out = out;
    return host->jacobian_times(context, &product);
  }
  [[nodiscard]] springnet_status factorise(double velocity_weight, double position_weight) const {
    auto request = sdk::sized<springnet_factorisation>();
    request.velocity_weight = velocity_weight;
    request.position_weight = position_weight;
    return host->factorise(context, &request);
  }
  [[nodiscard]] springnet_status project(double* values) const {
    auto projection = sdk::sized<springnet_projection>();
    projection.values = values;
    return host->project(context, &projection);
  }
  [[nodiscard]] springnet_status project_state(double time, const springnet_vectors& position,
                                               const springnet_vectors& velocity) const {
    auto projection = sdk::sized<springnet_state_projection>();
    projection.time = time;
    projection.position = position;
    projection.velocity = velocity;
    return host->project_state(context, &projection);
  }
  [[nodiscard]] springnet_status event_values(const springnet_evaluation* at, double* values) const {
    auto request = sdk::sized<springnet_event_values>();
    request.at = at;
    request.values = values;
    return host->event_values(context, &request);
  }
  [[nodiscard]] springnet_status fire_events(double time, springnet_state* any, const std::int32_t* fired) const {
    auto firing = sdk::sized<springnet_event_firing>();
    firing.time = time;
    firing.state = any;
    firing.fired = fired;
    return host->fire_events(context, &firing);
  }
  void report_number(const char* name, double value) const {
    auto number = sdk::sized<springnet_number_report>();
    number.name = name;
    number.value = value;
    host->report(context, &number);
  }
  void note(const char* text) const {
    auto given = sdk::sized<springnet_user_note>();
    given.text = text;
    host->note(context, &given);
  }

  [[nodiscard]] springnet_evaluation at() const { return sdk::evaluation_at(until, *state); }
  // A search for touches in the whole step, whose states are nan.
  [[nodiscard]] springnet_impact_search search() const {
    auto search = sdk::sized<springnet_impact_search>();
    search.step_from = search.from = from;
    search.step_until = search.until = until;
    search.user = const_cast<StepContext*>(this);
    search.state_at = [](void* user, const springnet_dense_output* output) -> springnet_status {
      for (const springnet_vectors& each : {output->position, output->velocity})
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
    sweep.update = [](void*, const springnet_node_batch*) -> springnet_status { return SPRINGNET_OK; };
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
// Those of the functions that came with ABI 2.1.
std::vector<Case> cases_2_1();

}  // namespace springnet::testing
