#include "simulation/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include <springnet/error.hpp>

#include "layers/elements.hpp"
#include "layers/message.hpp"

namespace springnet {
namespace {

constexpr std::uint32_t no_node = 0xffffffffu;
// A node this close to a surface, in units of the length scale, lies on it.
constexpr double coincidence = 1e-10;

std::vector<double> masses(const Network& network, const std::vector<std::uint32_t>& user) {
  std::vector<double> mass;
  mass.reserve(user.size());
  for (const std::uint32_t k : user) mass.push_back(network.nodes()[k].mass);
  return mass;
}

}  // namespace

Engine::Engine(const Network& network, const PluginHost& plugins, const SimulationOptions& options)
    : layout_(network, plugins, options.renumber),
      mass_(masses(network, layout_.ordering().user)),
      evaluator_(layout_, mass_, options.instruction_set, options.threads),
      loads_(network, layout_.ordering().engine),
      contact_(network, layout_.ordering().user, mass_),
      linearisation_(layout_, evaluator_, contact_.constrained()),
      state_(layout_.node_count()),
      time_resolution_(1e-9 * options.time_step) {
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    const Node& node = network.nodes()[layout_.ordering().user[k]];
    const springnet_vectors &p = state_.view.position, &v = state_.view.velocity;
    p.x[k] = node.position[0];
    p.y[k] = node.position[1];
    p.z[k] = node.position[2];
    v.x[k] = node.fixed ? 0.0 : node.velocity[0];
    v.y[k] = node.fixed ? 0.0 : node.velocity[1];
    v.z[k] = node.fixed ? 0.0 : node.velocity[2];
  }
  for (const Cut& cut : network.cuts()) {
    ScheduledCut scheduled{cut.time, cut.springs, std::nullopt};
    if (!cut.polygon.empty()) scheduled.polygon.emplace(cut.polygon);
    cuts_.push_back(std::move(scheduled));
  }
  loads_.set_interval(0.0, std::numeric_limits<double>::infinity());
  perform_due_cuts();
  if (perform_due_ruptures() != SPRINGNET_OK) throw Error(ErrorKind::simulation, message_.text);
  set_scales();
  start_contacts();
}

void Engine::changed() noexcept {
  ++revision_;
  forces_stale_ = true;
  unsettled_ = true;
}

const State& Engine::state() {
  if (forces_stale_) {
    if (evaluator_.evaluate(time_, state_.nodes(), loads_.external(), state_.forces(), {}, message_) != SPRINGNET_OK)
      throw Error(ErrorKind::simulation, message_.text);
    forces_stale_ = false;
  }
  return state_;
}

double Engine::contact_tolerance() const noexcept {
  // Rounding of positions far from the origin, beside the part of the length scale that does not matter.
  double size = 0.0;
  const springnet_vectors& p = state_.view.position;
  for (const double* component : {p.x, p.y, p.z})
    for (std::uint32_t k = 0; k < layout_.node_count(); ++k) size = std::max(size, std::abs(component[k]));
  return coincidence * info_.length_scale + 8.0 * std::numeric_limits<double>::epsilon() * size;
}

// A node that starts on a surface with a force into it is held from the start.
void Engine::start_contacts() {
  const std::vector<Plane>& planes = contact_.planes();
  if (planes.empty()) return;
  const double tolerance = contact_tolerance();
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    if (contact_.fixed()[k] != 0) continue;
    const springnet_vectors& p = state_.view.position;
    for (std::size_t j = 0; j < planes.size(); ++j) {
      const double distance = contact_.distance(j, {p.x[k], p.y[k], p.z[k]});
      if (distance < -tolerance)
        throw Error(
            ErrorKind::input,
            fmt::format("node {} starts {} m behind plane '{}' (number {}), where no node can be; move the body "
                        "or the plane, or turn the plane's normal towards the body",
                        layout_.ordering().user[k], -distance, planes[j].name, j));
    }
  }
  settle_contacts(time_, state_);
}

// Typical length, velocity and force, from which tolerances are made: mean rest length; the greatest initial speed or
// the speed that the greatest initial acceleration reaches over that length; the greatest weight, load, net force or
// force that holds the greatest initial speed on a circle of that length.
void Engine::set_scales() {
  double length = 0.0;
  std::size_t count = 0;
  for (std::uint32_t s = 0; s < layout_.spring_count(); ++s) {
    const double rest = layout_.group_of(s).columns[0][layout_.laws().row[s]];
    if (rest > 0.0) {
      length += rest;
      ++count;
    }
  }
  length = count > 0 ? length / static_cast<double>(count) : 1.0;
  double speed = 0.0, acceleration = 0.0, force = 0.0, mass = 0.0;
  const State& now = state();
  const double load = loads_.greatest();
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    const springnet_state& s = now.view;
    const double v = Vector3(s.velocity.x[k], s.velocity.y[k], s.velocity.z[k]).norm();
    const double f = std::max(load, Vector3(s.force.x[k], s.force.y[k], s.force.z[k]).norm());
    speed = std::max(speed, v);
    mass = std::max(mass, mass_[k]);
    acceleration = std::max(acceleration, f / mass_[k]);
    force = std::max({force, f, mass_[k] * loads_.gravity().norm(), mass_[k] * v * v / length});
  }
  const auto or_one = [](double value, double fallback) {
    return std::isfinite(value) && value > 0.0 ? value : fallback;
  };
  info_.length_scale = length;
  info_.velocity_scale = or_one(std::max(speed, std::sqrt(acceleration * length)), length);
  info_.force_scale = or_one(force, or_one(mass * length, 1.0));
}

const springnet_network& Engine::network_info() {
  if (info_revision_ != revision_) {
    info_.struct_size = sizeof info_;
    info_.node_count = layout_.node_count();
    info_.spring_count = layout_.live_count();
    info_.internal_count = 0;
    info_.revision = revision_;
    info_.unit_count = static_cast<std::uint32_t>(layout_.units().size());
    info_.event_count = static_cast<std::uint32_t>(event_sources().size());
    info_.plane_count = static_cast<std::uint32_t>(contact_.planes().size());
    info_.mass = mass_.data();
    info_.fixed = contact_.fixed().data();
    info_.held = contact_.held().data();
    info_.user_number = layout_.ordering().user.data();
    info_.neighbour_start = layout_.neighbour_start().data();
    info_.neighbours = layout_.neighbours().data();
    info_revision_ = revision_;
  }
  return info_;
}

springnet_status Engine::begin_step(double from, double until) {
  non_finite_.clear();
  if (loads_.set_interval(from, until)) changed();
  if (!unsettled_) {
    contact_.begin_step();
    return SPRINGNET_OK;
  }
  // A load that was switched, a cut, a change by the embedding program: the same nodes are held, and the same springs
  // broken, whatever the integrator and the length of its steps.
  unsettled_ = false;
  const springnet_status status = perform_due_ruptures();
  if (status == SPRINGNET_OK) settle_contacts(time_, state_);
  contact_.begin_step();
  return status;
}

void Engine::explain(double time, const layers::NodeArrays& nodes) {
  if (non_finite_.empty()) non_finite_ = explain_failure(layout_, evaluator_.instruction_set(), time, nodes);
}

// What is known of an evaluation that a law or a neuron ended: which spring it was, if it was a law.
springnet_status Engine::failed(springnet_status status, double time, const layers::NodeArrays& nodes) {
  const std::string reason = explain_failure(layout_, evaluator_.instruction_set(), time, nodes);
  if (!reason.empty()) set_message(message_, reason);
  non_finite_ = message_.text;
  return status;
}

namespace {

// What the finished tiles of an evaluation or a sweep need.
struct TileContext {
  const layers::Evaluator* evaluator;
  const springnet_sweep* sweep = nullptr;
  Contact* contact = nullptr;
  bool swept = false;
  springnet_vectors acceleration{};
  double time;
  layers::NodeArrays nodes;
  layers::ForceArrays force;
  std::atomic<bool> finite{true};
  std::atomic<std::uint32_t> bad_neuron{no_node};  // first node whose force is finite and its acceleration is not
};

bool all_finite(const double* const values[3], std::uint32_t count) {
  double sum = 0.0;
  for (int c = 0; c < 3; ++c)
    for (std::uint32_t i = 0; i < count; ++i) sum += values[c][i] * 0.0;
  return sum == 0.0;
}

void note_bad_neuron(TileContext& context, std::uint32_t first, std::uint32_t count,
                     const double* const acceleration[3]) {
  for (std::uint32_t i = 0; i < count; ++i) {
    if (std::isfinite(acceleration[0][i]) && std::isfinite(acceleration[1][i]) && std::isfinite(acceleration[2][i]))
      continue;
    std::uint32_t least = context.bad_neuron.load();
    while (first + i < least && !context.bad_neuron.compare_exchange_weak(least, first + i)) {
    }
    return;
  }
}

// Accelerations of a tile, then the integrator's update of its nodes, then fixation and contact.
springnet_status finish_tile(void* user, std::uint32_t unit, std::uint32_t first, std::uint32_t count,
                             springnet_message& message) {
  TileContext& context = *static_cast<TileContext*>(user);
  const double* force[3] = {context.force.x + first, context.force.y + first, context.force.z + first};
  const bool finite = all_finite(force, count);
  if (!finite) context.finite.store(false, std::memory_order_relaxed);
  const bool in_place = context.sweep == nullptr;
  if (in_place && context.acceleration.x == nullptr) return SPRINGNET_OK;
  alignas(64) double local[3][layers::tile_nodes];
  double* acceleration[3] = {local[0], local[1], local[2]};
  if (in_place) {
    acceleration[0] = context.acceleration.x + first;
    acceleration[1] = context.acceleration.y + first;
    acceleration[2] = context.acceleration.z + first;
  }
  const springnet_status status = context.evaluator->accelerations(first, count, context.time, context.nodes, force,
                                                                   acceleration, nullptr, nullptr, nullptr, message);
  if (status != SPRINGNET_OK) return status;
  if (finite && !all_finite(acceleration, count)) note_bad_neuron(context, first, count, acceleration);
  if (in_place) {
    for (std::uint32_t i = 0; i < count; ++i)
      if (context.contact->stays(first + i, context.swept))
        acceleration[0][i] = acceleration[1][i] = acceleration[2][i] = 0.0;
    return SPRINGNET_OK;
  }
  springnet_node_batch batch{};
  batch.struct_size = sizeof batch;
  batch.first = first;
  batch.count = count;
  batch.unit = unit;
  batch.force = {force[0], force[1], force[2]};
  batch.acceleration = {acceleration[0], acceleration[1], acceleration[2]};
  context.sweep->update(context.sweep->user, &batch);
  context.contact->constrain(first, count, force, context.sweep->start_position, context.sweep->next_position,
                             context.sweep->next_velocity);
  return SPRINGNET_OK;
}

}  // namespace

// Remembers why the answers of an evaluation are not finite. True if they are.
bool Engine::check_finite(bool forces, std::uint32_t bad_neuron, double time, const layers::NodeArrays& nodes) {
  if (forces && bad_neuron == no_node) return true;
  if (!forces) {
    explain(time, nodes);
  } else if (non_finite_.empty()) {
    non_finite_ = fmt::format("neuron '{}' answered an acceleration that is not finite for node {}",
                              layout_.laws().neurons[layout_.neuron_kind()[bad_neuron]].component->id(),
                              layout_.ordering().user[bad_neuron]);
  }
  return false;
}

springnet_status Engine::evaluate(const springnet_evaluation& request) {
  TileContext context{};
  context.evaluator = &evaluator_;
  context.contact = &contact_;
  context.swept = swept_;
  context.acceleration = request.acceleration;
  context.time = request.time;
  context.nodes = node_arrays(request.position, request.velocity);
  if (request.force.x != nullptr) {
    context.force = {request.force.x, request.force.y, request.force.z};
  } else {
    const std::size_t pitch = pitch_of(layout_.node_count());
    scratch_.resize(3 * pitch);
    context.force = {scratch_.data(), scratch_.data() + pitch, scratch_.data() + 2 * pitch};
  }
  const springnet_status status = evaluator_.evaluate(request.time, context.nodes, loads_.external(), context.force,
                                                      {finish_tile, &context}, message_);
  if (status != SPRINGNET_OK) return failed(status, request.time, context.nodes);
  if (check_finite(context.finite, context.bad_neuron, request.time, context.nodes)) return SPRINGNET_OK;
  set_message(message_, non_finite_);
  return SPRINGNET_RECOVERABLE;
}

springnet_status Engine::evaluate_nodes(const springnet_evaluation& request, const std::uint32_t* nodes,
                                        std::uint32_t count) {
  const layers::FlushDenormals flush;
  const layers::NodeArrays arrays = node_arrays(request.position, request.velocity);
  const layers::ExternalForces external = loads_.external();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t k = nodes[i];
    Vector3 force, a = Vector3::Zero();
    springnet_status status = evaluator_.evaluate_node(k, request.time, arrays, external, force, message_);
    if (status == SPRINGNET_OK && request.acceleration.x != nullptr && !contact_.stays(k, swept_)) {
      const double* f[3] = {&force[0], &force[1], &force[2]};
      double* const out[3] = {&a[0], &a[1], &a[2]};
      status = evaluator_.accelerations(k, 1, request.time, arrays, f, out, nullptr, nullptr, nullptr, message_);
    }
    if (status != SPRINGNET_OK) return failed(status, request.time, arrays);
    if (!check_finite(force.allFinite(), a.allFinite() ? no_node : k, request.time, arrays)) {
      set_message(message_, non_finite_);
      return SPRINGNET_RECOVERABLE;
    }
    const auto put = [k](const springnet_vectors& v, const Vector3& value) {
      if (v.x == nullptr) return;
      v.x[k] = value[0];
      v.y[k] = value[1];
      v.z[k] = value[2];
    };
    put(request.force, force);
    put(request.acceleration, a);
  }
  return SPRINGNET_OK;
}

springnet_status Engine::sweep(const springnet_sweep& sweep) {
  swept_ = true;
  TileContext context{};
  context.evaluator = &evaluator_;
  context.sweep = &sweep;
  context.contact = &contact_;
  context.time = sweep.time;
  context.nodes = node_arrays(sweep.position, sweep.velocity);
  context.force = {sweep.force.x, sweep.force.y, sweep.force.z};
  springnet_status status = SPRINGNET_OK;
  if (sweep.order == nullptr) {
    status = evaluator_.evaluate(sweep.time, context.nodes, loads_.external(), context.force, {finish_tile, &context},
                                 message_);
  } else {
    const layers::FlushDenormals flush;
    const layers::ExternalForces external = loads_.external();
    for (std::uint32_t i = 0; i < sweep.order_count && status == SPRINGNET_OK; ++i) {
      const std::uint32_t k = sweep.order[i];
      Vector3 force;
      status = evaluator_.evaluate_node(k, sweep.time, context.nodes, external, force, message_);
      context.force.x[k] = force[0];
      context.force.y[k] = force[1];
      context.force.z[k] = force[2];
      // Before its update: afterwards the node's own outputs would not be finite either.
      if (status == SPRINGNET_OK && !force.allFinite()) explain(sweep.time, context.nodes);
      if (status == SPRINGNET_OK) status = finish_tile(&context, 0, k, 1, message_);
    }
  }
  if (status != SPRINGNET_OK) return failed(status, sweep.time, context.nodes);
  // The integrator sees for itself that the sweep diverged; the host remembers why.
  static_cast<void>(check_finite(context.finite, context.bad_neuron, sweep.time, context.nodes));
  return SPRINGNET_OK;
}

springnet_status Engine::linearise(const springnet_evaluation& at) {
  return linearisation_.update(at.time, node_arrays(at.position, at.velocity), loads_.external(), message_);
}

void Engine::set_node(std::uint32_t node, const std::optional<Vector3>& position,
                      const std::optional<Vector3>& velocity) {
  const auto put = [node](const springnet_vectors& v, const Vector3& value) {
    v.x[node] = value[0];
    v.y[node] = value[1];
    v.z[node] = value[2];
  };
  if (position) {
    put(state_.view.position, *position);
    contact_.release(node);
  }
  if (velocity) {
    put(state_.view.velocity, *velocity);
    if (contact_.held()[node] != 0) {
      // What lifts it releases it; along the surface and into it the surface holds it.
      const Plane& plane = contact_.planes()[static_cast<std::size_t>(contact_.plane_of(node))];
      if (plane.normal.dot(*velocity) > 0.0) {
        contact_.release(node);
        note(Event::Kind::released, time_, layout_.ordering().user[node]);
      } else {
        put(state_.view.velocity, Vector3::Zero());
      }
    }
  }
  changed();
}

void Engine::set_fixed(std::uint32_t node, bool fixed) {
  contact_.set_fixed(node, fixed);
  set_node(node, std::nullopt, fixed ? std::optional<Vector3>(Vector3::Zero()) : std::nullopt);
}

}  // namespace springnet
