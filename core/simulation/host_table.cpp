#include "simulation/host_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <string>

#include <springnet/error.hpp>
#include <springnet/sdk/message.hpp>

#include "profile/stage.hpp"
#include "simulation/dominant.hpp"
#include "simulation/requests.hpp"

namespace springnet {
namespace {

Engine& engine_of(void* context) { return *static_cast<Engine*>(context); }

// Runs the action of one host function on behalf of an integrator.
template <class Action>
springnet_status guarded(void* context, const char* function, const Action& action) noexcept {
  if (context == nullptr) return SPRINGNET_FAILED;
  Engine& engine = engine_of(context);
  const auto refuse = [&](const char* reason, bool misuse) noexcept {
    try {
      engine.calls().refuse(misuse ? fmt::format("springnet_host::{}: {}", function, reason) : std::string(reason),
                            misuse);
    } catch (const std::exception&) {
      sdk::detail::write_message(&engine.model().journal.message, "out of memory");
    }
  };
  try {
    return action(engine);
  } catch (const Error& error) {
    refuse(error.what(), error.kind() == ErrorKind::plugin);
  } catch (const std::exception& error) {
    refuse(error.what(), false);
  } catch (...) {
    refuse("unknown failure in the host", false);
  }
  return SPRINGNET_FAILED;
}

// The same for functions that change the engine or use its buffers. Each is a stage of a profile, by its own name
// unless another one is given.
template <class Action>
springnet_status outside_of_sweeps(void* context, const char* function, const char* stage_name,
                                   const Action& action) noexcept {
  return guarded(context, function, [&](Engine& engine) -> springnet_status {
    engine.calls().require_no_callback();
    const profile::Stage stage(stage_name);
    return action(engine);
  });
}
template <class Action>
springnet_status outside_of_sweeps(void* context, const char* function, const Action& action) noexcept {
  return outside_of_sweeps(context, function, function, action);
}

// The same for functions of the derivatives, which need a call of linearise first.
template <class Action>
springnet_status linearised(void* context, const char* function, const Action& action) noexcept {
  return outside_of_sweeps(context, function, [&](Engine& engine) -> springnet_status {
    if (!engine.linear().known()) throw Error(ErrorKind::plugin, "derivatives were asked for before linearise");
    return action(engine);
  });
}

const springnet_network* network(void* context) {
  const springnet_network* info = nullptr;
  static_cast<void>(guarded(context, "network", [&](Engine& engine) -> springnet_status {
    info = &engine.network_info();
    return SPRINGNET_OK;
  }));
  return info;
}

const springnet_network* network_with_neighbours(void* context) {
  const springnet_network* info = nullptr;
  static_cast<void>(outside_of_sweeps(context, "network_with_neighbours", [&](Engine& engine) -> springnet_status {
    info = &engine.network_with_neighbours();
    return SPRINGNET_OK;
  }));
  return info;
}

springnet_state* state_create(void* context) {
  springnet_state* state = nullptr;
  static_cast<void>(guarded(context, "state_create", [&](Engine& engine) -> springnet_status {
    state = engine.calls().create_state();
    return SPRINGNET_OK;
  }));
  return state;
}

void state_destroy(void* context, springnet_state* state) {
  if (context != nullptr) engine_of(context).calls().destroy_state(state);
}

const springnet_state* committed(void* context, double* time) {
  const springnet_state* state = nullptr;
  static_cast<void>(guarded(context, "committed", [&](Engine& engine) -> springnet_status {
    state = &engine.model().state.view;
    if (time != nullptr) *time = engine.model().time;
    return SPRINGNET_OK;
  }));
  return state;
}

void require_order(double from, double until) {
  require_finite(from, "from");
  if (!(until > from))
    throw Error(ErrorKind::plugin, fmt::format("a step from {} s has to end later than at {} s", from, until));
}

springnet_status begin_step(void* context, double from, double until) {
  return outside_of_sweeps(context, "begin_step", "begin", [&](Engine& engine) {
    require_order(from, until);
    return engine.begin_step(from, until);
  });
}
springnet_status begin_interval(void* context, double from, double until) {
  return outside_of_sweeps(context, "begin_interval", "begin", [&](Engine& engine) {
    require_order(from, until);
    return engine.begin_interval(from, until);
  });
}
springnet_status evaluate(void* context, const springnet_evaluation* evaluation) {
  return outside_of_sweeps(context, "evaluate",
                           [&](Engine& engine) { return engine.sweep().evaluate(checked(evaluation)); });
}
springnet_status evaluate_nodes(void* context, const springnet_evaluation* evaluation, const std::uint32_t* nodes,
                                std::uint32_t count) {
  return guarded(context, "evaluate_nodes", [&](Engine& engine) {
    check_nodes(nodes, count, engine.model().node_count());
    const profile::Tile tile;  // often one node: too short for a stage
    const profile::Part part("evaluate_nodes");
    return engine.sweep().evaluate_nodes(checked(evaluation), nodes, count);
  });
}
springnet_status sweep(void* context, const springnet_sweep* request) {
  return outside_of_sweeps(context, "sweep", [&](Engine& engine) {
    return engine.run_sweep(checked(request, engine.model().node_count()));
  });
}
springnet_status linearise(void* context, const springnet_evaluation* at) {
  return outside_of_sweeps(context, "linearise",
                           [&](Engine& engine) { return engine.linear().linearise(checked(at)); });
}
springnet_status jacobian_times(void* context, const double* dp, const double* dv, double* out) {
  return linearised(context, "jacobian_times", [&](Engine& engine) {
    require_array(dp, "dp");
    require_array(dv, "dv");
    require_array(out, "out");
    return engine.linear().times(dp, dv, out);
  });
}
springnet_status diagonal_blocks(void* context, double velocity_weight, double position_weight, double* out) {
  return linearised(context, "diagonal_blocks", [&](Engine& engine) -> springnet_status {
    require_array(out, "out");
    engine.linear().diagonal_blocks(velocity_weight, position_weight, out);
    return SPRINGNET_OK;
  });
}
springnet_status factorise(void* context, double velocity_weight, double position_weight) {
  return outside_of_sweeps(context, "factorise", [&](Engine& engine) {
    require_finite(velocity_weight, "velocity_weight");
    require_finite(position_weight, "position_weight");
    return engine.linear().factorise(velocity_weight, position_weight);
  });
}
springnet_status solve(void* context, std::int32_t transposed, const double* right_side, double* x) {
  return outside_of_sweeps(context, "solve", [&](Engine& engine) {
    require_array(right_side, "right_side");
    require_array(x, "x");
    return engine.linear().solve(transposed != 0, right_side, x);
  });
}
springnet_status prepare_system(void* context, const springnet_linear_system* request) {
  return outside_of_sweeps(context, "prepare_system", [&](Engine& engine) {
    const springnet_linear_system& system = checked(request);
    if (system.at == nullptr && !engine.linear().known())
      throw Error(ErrorKind::plugin, "derivatives were asked for before linearise");
    return engine.linear().prepare(system);
  });
}
springnet_status solve_system(void* context, springnet_linear_solve* request) {
  return outside_of_sweeps(context, "solve_system",
                           [&](Engine& engine) { return engine.linear().solve_prepared(checked(request)); });
}
double time_left(void* context) {
  return context == nullptr ? std::numeric_limits<double>::infinity() : engine_of(context).model().deadline.left();
}
springnet_status event_values(void* context, const springnet_evaluation* at, double* values, std::int32_t* directions) {
  return outside_of_sweeps(context, "event_values", "events", [&](Engine& engine) {
    if (engine.network_info().event_count > 0) require_array(values, "values");
    return engine.contact_events().values(checked(at), values, directions);
  });
}
springnet_status fire_events(void* context, double time, springnet_state* state, const std::int32_t* fired) {
  return outside_of_sweeps(context, "fire_events", "events", [&](Engine& engine) {
    engine.calls().require_advancing();
    require_finite(time, "time");
    if (engine.network_info().event_count > 0) require_array(fired, "fired");
    return engine.fire_events(time, engine.calls().created_state(state), fired);
  });
}
springnet_status time_of_impact(void* context, const springnet_impact_search* search, double* time) {
  return outside_of_sweeps(context, "time_of_impact", "events", [&](Engine& engine) {
    require_array(time, "time");
    return engine.time_of_impact(checked(search), *time);
  });
}
double next_discontinuity(void* context, double time) {
  if (context == nullptr) return std::numeric_limits<double>::infinity();
  return engine_of(context).next_discontinuity(time);
}
springnet_status commit(void* context, double time, springnet_state* state) {
  return outside_of_sweeps(context, "commit", [&](Engine& engine) {
    engine.calls().require_advancing();
    return engine.commit(time, engine.calls().created_state(state));
  });
}
void report(void* context, const char* name, double value) {
  static_cast<void>(guarded(context, "report", [&](Engine& engine) -> springnet_status {
    require_array(name, "name");
    engine.model().journal.report(name, value);
    return SPRINGNET_OK;
  }));
}
springnet_status constrain(void* context, const springnet_sweep* request) {
  return outside_of_sweeps(context, "constrain",
                           [&](Engine& engine) { return engine.constrain(checked_end(request)); });
}
springnet_status project(void* context, const double* mobility, double* values) {
  return linearised(context, "project", [&](Engine& engine) {
    require_array(values, "values");
    return engine.linear().project(mobility, values);
  });
}
springnet_status project_state(void* context, double time, springnet_vectors position, springnet_vectors velocity) {
  return outside_of_sweeps(context, "project_state", [&](Engine& engine) {
    require_finite(time, "time");
    require_vectors(position, "position");
    require_vectors(velocity, "velocity");
    return engine.project_state(time, position, velocity);
  });
}
void note(void* context, const char* text) {
  static_cast<void>(guarded(context, "note", [&](Engine& engine) -> springnet_status {
    require_array(text, "text");
    engine.model().journal.note(text);
    return SPRINGNET_OK;
  }));
}
springnet_status linear_sweep(void* context, const springnet_sweep* request) {
  return linearised(context, "linear_sweep", [&](Engine& engine) {
    return engine.linear().sweep(checked_linear(request, engine.model().node_count()), engine.network_info());
  });
}

struct MapFailed {
  springnet_status status;
};

springnet_status dominant_eigenvalue(void* context, springnet_eigenvalue_search* request) {
  return outside_of_sweeps(context, "dominant_eigenvalue", [&](Engine&) -> springnet_status {
    springnet_eigenvalue_search& search = checked(request);
    const auto size = static_cast<Eigen::Index>(search.size);
    DominantOptions options;
    if (search.wanted == SPRINGNET_LARGEST_REAL_PART) options.wanted = Wanted::largest_real;
    options.basis = search.most_vectors;
    options.applications = search.most_applications;
    options.tolerance = search.tolerance;
    Eigen::VectorXd start = Eigen::Map<const Eigen::VectorXd>(search.start, size);
    if (size > 0 && !(start.norm() > 0.0)) throw Error(ErrorKind::plugin, "start is 0");
    try {
      const Dominant found = springnet::dominant_eigenvalue(
          [&](Eigen::VectorXd& x) {
            const springnet_status status = search.map(search.user, x.data());
            if (status != SPRINGNET_OK) throw MapFailed{status};
          },
          start, options);
      search.real = found.value.real();
      search.imaginary = found.value.imag();
      search.error = found.error;
      search.applications = found.applications;
      if (found.real.size() == size && size > 0) {
        if (search.mode_real != nullptr) std::copy_n(found.real.data(), size, search.mode_real);
        if (search.mode_imaginary != nullptr) std::copy_n(found.imaginary.data(), size, search.mode_imaginary);
        std::copy_n(start.data(), size, search.start);
      }
    } catch (const MapFailed& failed) {
      return failed.status;
    }
    return SPRINGNET_OK;
  });
}
springnet_message* message(void* context) {
  return context == nullptr ? nullptr : &engine_of(context).model().journal.message;
}

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
  host.begin_interval = begin_interval;
  host.time_of_impact = time_of_impact;
  host.linear_sweep = linear_sweep;
  host.dominant_eigenvalue = dominant_eigenvalue;
  host.prepare_system = prepare_system;
  host.solve_system = solve_system;
  host.time_left = time_left;
  host.network_with_neighbours = network_with_neighbours;
  return host;
}

}  // namespace springnet
