#include "simulation/host_table.hpp"

#include <fmt/format.h>

#include <exception>
#include <limits>
#include <new>

#include <springnet/error.hpp>

#include "layers/message.hpp"

namespace springnet {
namespace {

Engine& engine_of(void* context) { return *static_cast<Engine*>(context); }

// Runs an action of the host on behalf of an integrator.
template <class Action>
springnet_status guarded(void* context, Action action) noexcept {
  try {
    return action(engine_of(context));
  } catch (const std::exception& error) {
    set_message(engine_of(context).message(), error.what());
  } catch (...) {
    set_message(engine_of(context).message(), "unknown failure in the host");
  }
  return SPRINGNET_FAILED;
}

// The same for an action on the derivatives, once there are any.
template <class Action>
springnet_status linearised(void* context, Action action) noexcept {
  return guarded(context, [&](Engine& engine) -> springnet_status {
    if (!engine.linearisation().known()) throw Error(ErrorKind::plugin, "derivatives were asked for before linearise");
    return action(engine);
  });
}

// Where the structs of ABI 1.0 ended: an integrator compiled against it gives no more.
constexpr std::size_t evaluation_size = SPRINGNET_SIZE_TO(springnet_evaluation, internal_rate);
constexpr std::size_t sweep_size = SPRINGNET_SIZE_TO(springnet_sweep, user);

// A request of an integrator, which has to be at least as large as ABI 1.0 made it.
template <class Request>
const Request& checked(const Request* request, const char* name, std::size_t least) {
  if (request == nullptr || request->struct_size < least)
    throw Error(ErrorKind::plugin, fmt::format("a {} of {} bytes was given where ABI 1.0 has {}; set its struct_size",
                                               name, request == nullptr ? 0 : request->struct_size, least));
  return *request;
}
const springnet_evaluation& checked(const springnet_evaluation* evaluation) {
  return checked(evaluation, "springnet_evaluation", evaluation_size);
}
const springnet_sweep& checked(const springnet_sweep* sweep) { return checked(sweep, "springnet_sweep", sweep_size); }

const springnet_network* network(void* context) {
  const springnet_network* info = nullptr;
  static_cast<void>(guarded(context, [&](Engine& engine) -> springnet_status {
    info = &engine.network_info();
    return SPRINGNET_OK;
  }));
  return info;
}

springnet_state* state_create(void* context) {
  try {
    return &(new State(engine_of(context).layout().node_count()))->view;
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void state_destroy(void*, springnet_state* state) {
  if (state != nullptr) delete &State::of(state);
}

const springnet_state* committed(void* context, double* time) {
  const springnet_state* state = nullptr;
  static_cast<void>(guarded(context, [&](Engine& engine) -> springnet_status {
    state = &engine.state_without_forces().view;
    if (time != nullptr) *time = engine.time();
    return SPRINGNET_OK;
  }));
  return state;
}

springnet_status begin_step(void* context, double from, double until) {
  return guarded(context, [&](Engine& engine) { return engine.begin_step(from, until); });
}
springnet_status evaluate(void* context, const springnet_evaluation* evaluation) {
  return guarded(context, [&](Engine& engine) { return engine.evaluate(checked(evaluation)); });
}
springnet_status evaluate_nodes(void* context, const springnet_evaluation* evaluation, const std::uint32_t* nodes,
                                std::uint32_t count) {
  return guarded(context, [&](Engine& engine) { return engine.evaluate_nodes(checked(evaluation), nodes, count); });
}
springnet_status sweep(void* context, const springnet_sweep* request) {
  return guarded(context, [&](Engine& engine) { return engine.sweep(checked(request)); });
}
springnet_status linearise(void* context, const springnet_evaluation* at) {
  return guarded(context, [&](Engine& engine) { return engine.linearise(checked(at)); });
}
springnet_status jacobian_times(void* context, const double* dp, const double* dv, double* out) {
  return linearised(context, [&](Engine& engine) { return engine.jacobian_times(dp, dv, out); });
}
springnet_status diagonal_blocks(void* context, double velocity_weight, double position_weight, double* out) {
  return linearised(context, [&](Engine& engine) -> springnet_status {
    engine.linearisation().diagonal_blocks(velocity_weight, position_weight, out);
    return SPRINGNET_OK;
  });
}
springnet_status factorise(void* context, double velocity_weight, double position_weight) {
  return guarded(context, [&](Engine& engine) { return engine.factorise(velocity_weight, position_weight); });
}
springnet_status solve(void* context, std::int32_t transposed, const double* right_side, double* x) {
  return guarded(context, [&](Engine& engine) {
    return engine.linearisation().solve(transposed != 0, right_side, x, engine.message());
  });
}
springnet_status event_values(void* context, const springnet_evaluation* at, double* values, std::int32_t* directions) {
  return guarded(context, [&](Engine& engine) { return engine.event_values(checked(at), values, directions); });
}
springnet_status fire_events(void* context, double time, springnet_state* state, const std::int32_t* fired) {
  return guarded(context, [&](Engine& engine) { return engine.fire_events(time, State::of(state), fired); });
}
double next_discontinuity(void* context, double time) { return engine_of(context).next_discontinuity(time); }
springnet_status commit(void* context, double time, springnet_state* state) {
  return guarded(context, [&](Engine& engine) { return engine.commit(time, State::of(state)); });
}
void report(void* context, const char* name, double value) {
  static_cast<void>(guarded(context, [&](Engine& engine) -> springnet_status {
    engine.report(name, value);
    return SPRINGNET_OK;
  }));
}
springnet_status constrain(void* context, const springnet_sweep* request) {
  return guarded(context, [&](Engine& engine) { return engine.constrain(checked(request)); });
}
springnet_status project(void* context, const double* mobility, double* values) {
  return linearised(context, [&](Engine& engine) { return engine.project(mobility, values); });
}
springnet_status project_state(void* context, double time, springnet_vectors position, springnet_vectors velocity) {
  return guarded(context, [&](Engine& engine) { return engine.project_state(time, position, velocity); });
}
void note(void* context, const char* text) {
  static_cast<void>(guarded(context, [&](Engine& engine) -> springnet_status {
    engine.note(text);
    return SPRINGNET_OK;
  }));
}
springnet_message* message(void* context) { return &engine_of(context).message(); }

}  // namespace

springnet_host make_host_table(Engine& engine) {
  springnet_host host{};
  host.struct_size = sizeof host;
  host.abi_minor = SPRINGNET_ABI_MINOR;
  host.context = &engine;
  host.network = network;
  host.state_create = state_create;
  host.state_destroy = state_destroy;
  host.committed = committed;
  host.begin_step = begin_step;
  host.evaluate = evaluate;
  host.evaluate_nodes = evaluate_nodes;
  host.sweep = sweep;
  host.linearise = linearise;
  host.jacobian_times = jacobian_times;
  host.diagonal_blocks = diagonal_blocks;
  host.factorise = factorise;
  host.solve = solve;
  host.event_values = event_values;
  host.fire_events = fire_events;
  host.next_discontinuity = next_discontinuity;
  host.commit = commit;
  host.report = report;
  host.message = message;
  host.constrain = constrain;
  host.project = project;
  host.project_state = project_state;
  host.note = note;
  return host;
}

}  // namespace springnet
