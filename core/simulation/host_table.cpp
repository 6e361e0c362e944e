#include "simulation/host_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <string>

#include <springnet/error.hpp>

#include "simulation/dominant.hpp"
#include "simulation/event_derivatives.hpp"
#include "simulation/host_calls.hpp"
#include "simulation/parameter_model.hpp"
#include "simulation/requests.hpp"

namespace springnet {
namespace {

using namespace host_calls;

// The bits of a request's kind, of which these are known.
void require_kind(std::uint32_t kind, std::uint32_t known) {
  if ((kind & ~known) != 0) throw Error(ErrorKind::plugin, fmt::format("kind {} has bits that are not known", kind));
}

springnet_status network(void* context, springnet_network_query* request) {
  const bool with_neighbours = request != nullptr && request->with_neighbours != 0;
  const auto answer = [&](Engine& engine) -> springnet_status {
    springnet_network_query& query = SPRINGNET_REQUEST(springnet_network_query, request, network);
    query.network = with_neighbours ? &engine.network_with_neighbours() : &engine.network_info();
    return SPRINGNET_OK;
  };
  return with_neighbours ? outside_of_sweeps(context, "network", answer) : guarded(context, "network", answer);
}
springnet_status create_state(void* context, springnet_state_creation* request) {
  return guarded(context, "create_state", [&](Engine& engine) -> springnet_status {
    springnet_state_creation& creation = SPRINGNET_REQUEST(springnet_state_creation, request, state);
    creation.state = engine.calls().create_state();
    return SPRINGNET_OK;
  });
}
springnet_status destroy_state(void* context, springnet_state* state) {
  if (context == nullptr) return SPRINGNET_FAILED;
  engine_of(context).calls().destroy_state(state);
  return SPRINGNET_OK;
}
springnet_status committed(void* context, springnet_committed* request) {
  return guarded(context, "committed", [&](Engine& engine) -> springnet_status {
    springnet_committed& answer = SPRINGNET_REQUEST(springnet_committed, request, state);
    answer.state = &engine.model().state.view;
    answer.time = engine.model().time;
    return SPRINGNET_OK;
  });
}
springnet_status begin(void* context, const springnet_interval* request) {
  return outside_of_sweeps(context, "begin", [&](Engine& engine) {
    const springnet_interval& interval = SPRINGNET_REQUEST(springnet_interval, request, until);
    const double from = interval.from, until = interval.until;
    require_finite(from, "from");
    if (!(until > from))
      throw Error(ErrorKind::plugin, fmt::format("a step from {} s has to end later than at {} s", from, until));
    return interval.own_steps != 0 ? engine.begin_interval(from, until, true) : engine.begin_step(from, until);
  });
}
springnet_status evaluate_nodes(void* context, const springnet_evaluation* request) {
  return guarded(context, "evaluate", [&](Engine& engine) {
    const springnet_evaluation& evaluation = checked(request);
    check_nodes(evaluation.nodes, evaluation.node_count, engine.model().node_count());
    const profile::Tile tile;  // often one node: too short for a stage
    const profile::Part part("evaluate_nodes");
    return engine.sweep().evaluate_nodes(evaluation);
  });
}
springnet_status evaluate(void* context, const springnet_evaluation* request) {
  const bool of_some = request != nullptr && request->struct_size >= SPRINGNET_SIZE_TO(springnet_evaluation, nodes) &&
                       request->nodes != nullptr;
  if (of_some) return evaluate_nodes(context, request);
  return outside_of_sweeps(context, "evaluate",
                           [&](Engine& engine) { return engine.sweep().evaluate(checked(request)); });
}
springnet_status sweep(void* context, const springnet_sweep* request) {
  return outside_of_sweeps(context, "sweep", [&](Engine& engine) {
    return engine.run_sweep(checked(request, engine.model().node_count()));
  });
}
springnet_status linearise(void* context, const springnet_linearisation* request) {
  return outside_of_sweeps(context, "linearise", [&](Engine& engine) {
    const springnet_linearisation& at = SPRINGNET_REQUEST(springnet_linearisation, request, elimination);
    if (!(at.elimination >= 0.0 && std::isfinite(at.elimination)))
      throw Error(ErrorKind::plugin, fmt::format("elimination is {} s, must be at least 0", at.elimination));
    return engine.linear().linearise(checked(at.at), at.elimination);
  });
}
springnet_status jacobian_times(void* context, const springnet_jacobian_product* request) {
  return linearised(context, "jacobian_times", [&](Engine& engine) {
    const springnet_jacobian_product& product = SPRINGNET_REQUEST(springnet_jacobian_product, request, out);
    require_array(product.dp, "dp");
    require_array(product.dv, "dv");
    require_array(product.out, "out");
    require_kind(product.kind, SPRINGNET_TRUE_FRICTION);
    return engine.linear().times(product.dp, product.dv, product.kind == SPRINGNET_TRUE_FRICTION, product.out);
  });
}
springnet_status jacobian_transposed_times(void* context, const springnet_transposed_product* request) {
  return linearised(context, "jacobian_transposed_times", [&](Engine& engine) {
    const springnet_transposed_product& product = SPRINGNET_REQUEST(springnet_transposed_product, request, by_velocity);
    require_array(product.weights, "weights");
    require_array(product.by_position, "by_position");
    require_array(product.by_velocity, "by_velocity");
    require_kind(product.kind, SPRINGNET_TRUE_FRICTION);
    return engine.linear().transposed_times(product.weights, product.kind == SPRINGNET_TRUE_FRICTION,
                                            product.by_position, product.by_velocity);
  });
}
springnet_status parameter_tangent(void* context, const springnet_parameter_product* request) {
  return outside_of_sweeps(context, "parameter_tangent",
                           [&](Engine& engine) { return engine.parameters().tangent(checked(request)); });
}
springnet_status parameter_cotangent(void* context, const springnet_parameter_product* request) {
  return outside_of_sweeps(context, "parameter_cotangent",
                           [&](Engine& engine) { return engine.parameters().cotangent(checked(request)); });
}
springnet_status event_derivative(void* context, springnet_event_derivative* request) {
  return outside_of_sweeps(context, "event_derivative", "events", [&](Engine& engine) {
    springnet_event_derivative& derivative = SPRINGNET_REQUEST(springnet_event_derivative, request, by_time);
    static_cast<void>(checked(derivative.at));
    check_sets(derivative.sets, derivative.set_count);
    return find_event_derivative(engine.model(), engine.contact_events(), engine.topology(), derivative);
  });
}
springnet_status change_internal(void* context, const springnet_internal_change* request) {
  return linearised(context, "change_internal", [&](Engine& engine) {
    const springnet_internal_change& change = SPRINGNET_REQUEST(springnet_internal_change, request, acceleration);
    if (engine.network_info().internal_count > 0) require_array(change.right_side, "right_side");
    return engine.linear().change_internal(change);
  });
}
springnet_status diagonal_blocks(void* context, const springnet_diagonal_blocks* request) {
  return linearised(context, "diagonal_blocks", [&](Engine& engine) -> springnet_status {
    const springnet_diagonal_blocks& blocks = SPRINGNET_REQUEST(springnet_diagonal_blocks, request, out);
    require_array(blocks.out, "out");
    engine.linear().diagonal_blocks(blocks.velocity_weight, blocks.position_weight, blocks.out);
    return SPRINGNET_OK;
  });
}
springnet_status factorise(void* context, const springnet_factorisation* request) {
  return outside_of_sweeps(context, "factorise", [&](Engine& engine) {
    const springnet_factorisation& weights = SPRINGNET_REQUEST(springnet_factorisation, request, position_weight);
    require_finite(weights.velocity_weight, "velocity_weight");
    require_finite(weights.position_weight, "position_weight");
    return engine.linear().factorise(weights.velocity_weight, weights.position_weight);
  });
}
springnet_status solve(void* context, const springnet_solve* request) {
  return outside_of_sweeps(context, "solve", [&](Engine& engine) {
    const springnet_solve& system = SPRINGNET_REQUEST(springnet_solve, request, x);
    require_array(system.right_side, "right_side");
    require_array(system.x, "x");
    return engine.linear().solve(system.transposed != 0, system.right_side, system.x);
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
springnet_status deadline(void* context, springnet_deadline* request) {
  return guarded(context, "deadline", [&](Engine& engine) -> springnet_status {
    SPRINGNET_REQUEST(springnet_deadline, request, time_left).time_left = engine.model().deadline.left();
    return SPRINGNET_OK;
  });
}
// The arrays of integrators have this size.
std::uint32_t event_count(Engine& engine) {
  const std::uint32_t told = engine.network_info().event_count;
  if (engine.contact_events().count() > told)
    throw Error(ErrorKind::simulation,
                fmt::format("there are {} events now, but {} were told for this revision of the network; please report "
                            "this",
                            engine.contact_events().count(), told));
  return told;
}
springnet_status event_values(void* context, const springnet_event_values* request) {
  return outside_of_sweeps(context, "event_values", "events", [&](Engine& engine) {
    const springnet_event_values& events = SPRINGNET_REQUEST(springnet_event_values, request, directions);
    if (event_count(engine) > 0) require_array(events.values, "values");
    if (SPRINGNET_HAS_FIELD(springnet_event_values, &events, surfaces))
      engine.contact_events().names(events.kinds, events.who, events.surfaces);
    return engine.contact_events().values(checked(events.at), events.values, events.directions);
  });
}
springnet_status fire_events(void* context, const springnet_event_firing* request) {
  return outside_of_sweeps(context, "fire_events", "events", [&](Engine& engine) {
    const springnet_event_firing& firing = SPRINGNET_REQUEST(springnet_event_firing, request, fired);
    engine.calls().require_advancing();
    require_finite(firing.time, "time");
    if (event_count(engine) > 0) require_array(firing.fired, "fired");
    return engine.fire_events(firing.time, engine.calls().created_state(firing.state), firing.fired);
  });
}
springnet_status time_of_impact(void* context, springnet_impact_search* request) {
  return outside_of_sweeps(context, "time_of_impact", "events",
                           [&](Engine& engine) { return engine.time_of_impact(checked(request)); });
}
springnet_status next_discontinuity(void* context, springnet_discontinuity* request) {
  return guarded(context, "next_discontinuity", [&](Engine& engine) -> springnet_status {
    springnet_discontinuity& next = SPRINGNET_REQUEST(springnet_discontinuity, request, time);
    next.time = engine.next_discontinuity(next.after);
    return SPRINGNET_OK;
  });
}
springnet_status commit(void* context, const springnet_commitment* request) {
  return outside_of_sweeps(context, "commit", [&](Engine& engine) {
    const springnet_commitment& commitment = SPRINGNET_REQUEST(springnet_commitment, request, state);
    engine.calls().require_advancing();
    return engine.commit(commitment.time, engine.calls().created_state(commitment.state));
  });
}
springnet_status report(void* context, const springnet_number_report* request) {
  return guarded(context, "report", [&](Engine& engine) -> springnet_status {
    const springnet_number_report& number = SPRINGNET_REQUEST(springnet_number_report, request, value);
    require_array(number.name, "name");
    require_kind(number.adds, 1);
    if (number.adds != 0)
      engine.model().journal.count(number.name, number.value);
    else
      engine.model().journal.report(number.name, number.value);
    return SPRINGNET_OK;
  });
}
springnet_status constrain(void* context, const springnet_sweep* request) {
  return outside_of_sweeps(context, "constrain",
                           [&](Engine& engine) { return engine.constrain(checked_end(request)); });
}
springnet_status project(void* context, const springnet_projection* request) {
  return outside_of_sweeps(context, "project", [&](Engine& engine) {
    const springnet_projection& projection = SPRINGNET_REQUEST(springnet_projection, request, values);
    // A system without a matrix has no derivatives at hand, but knows how surfaces answer.
    const bool is_ready = (projection.kind & SPRINGNET_TRUE_FRICTION) != 0 && engine.linear().is_prepared();
    if (!is_ready && !engine.linear().known())
      throw Error(ErrorKind::plugin, "derivatives were asked for before linearise");
    require_array(projection.values, "values");
    require_kind(projection.kind, SPRINGNET_TRANSPOSED | SPRINGNET_TRUE_FRICTION);
    const bool transposed = (projection.kind & SPRINGNET_TRANSPOSED) != 0;
    if ((projection.kind & SPRINGNET_TRUE_FRICTION) == 0)
      return engine.linear().project(projection.mobility, projection.values, transposed);
    if (projection.mobility != nullptr)
      throw Error(ErrorKind::plugin, "with SPRINGNET_TRUE_FRICTION, mobility must be a null pointer");
    engine.linear().project_accelerations(transposed, projection.values);
    return springnet_status{SPRINGNET_OK};
  });
}
springnet_status project_state(void* context, const springnet_state_projection* request) {
  return outside_of_sweeps(context, "project_state", [&](Engine& engine) {
    const springnet_state_projection& projection = SPRINGNET_REQUEST(springnet_state_projection, request, velocity);
    require_finite(projection.time, "time");
    require_vectors(projection.position, "position");
    require_vectors(projection.velocity, "velocity");
    return engine.project_state(projection.time, projection.position, projection.velocity);
  });
}
springnet_status note(void* context, const springnet_user_note* request) {
  return guarded(context, "note", [&](Engine& engine) -> springnet_status {
    const springnet_user_note& given = SPRINGNET_REQUEST(springnet_user_note, request, text);
    require_array(given.text, "text");
    const char* const topic = SPRINGNET_HAS_FIELD(springnet_user_note, &given, topic) ? given.topic : nullptr;
    engine.model().journal.note(given.text, topic == nullptr ? "" : topic);
    return SPRINGNET_OK;
  });
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
            const springnet_linear_image image{sizeof image, 0, x.data()};
            const springnet_status status = search.map(search.user, &image);
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

}  // namespace

springnet_host make_host_table(Engine& engine) {
  springnet_host host{};
  host.struct_size = sizeof host;
  host.abi_minor = SPRINGNET_ABI_MINOR;
  host.context = &engine;
  host.message = &engine.model().journal.message;
  host.network = network;
  host.create_state = create_state;
  host.destroy_state = destroy_state;
  host.committed = committed;
  host.begin = begin;
  host.evaluate = evaluate;
  host.sweep = sweep;
  host.linearise = linearise;
  host.jacobian_times = jacobian_times;
  host.change_internal = change_internal;
  host.diagonal_blocks = diagonal_blocks;
  host.factorise = factorise;
  host.solve = solve;
  host.prepare_system = prepare_system;
  host.solve_system = solve_system;
  host.linear_sweep = linear_sweep;
  host.dominant_eigenvalue = dominant_eigenvalue;
  host.event_values = event_values;
  host.fire_events = fire_events;
  host.next_discontinuity = next_discontinuity;
  host.time_of_impact = time_of_impact;
  host.commit = commit;
  host.constrain = constrain;
  host.project = project;
  host.project_state = project_state;
  host.report = report;
  host.note = note;
  host.deadline = deadline;
  host.jacobian_transposed_times = jacobian_transposed_times;
  host.parameter_tangent = parameter_tangent;
  host.parameter_cotangent = parameter_cotangent;
  host.event_derivative = event_derivative;
  add_functions_2_1(host);
  return host;
}

}  // namespace springnet
