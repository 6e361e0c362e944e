#include "simulation/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include <springnet/error.hpp>

#include "layers/elements.hpp"

namespace springnet {
namespace {

std::vector<double> masses(const Network& network, const std::vector<std::uint32_t>& user) {
  std::vector<double> mass;
  mass.reserve(user.size());
  for (const std::uint32_t k : user) mass.push_back(network.nodes()[k].mass);
  return mass;
}

}  // namespace

void set_message(springnet_message& message, const std::string& text) noexcept {
  const std::size_t size = std::min(text.size(), sizeof message.text - 1);
  std::memcpy(message.text, text.data(), size);
  message.text[size] = '\0';
}

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
  start_contacts();
  set_scales();
}

void Engine::changed() noexcept {
  ++revision_;
  forces_stale_ = true;
}

const State& Engine::state() {
  if (forces_stale_) {
    if (evaluator_.evaluate(time_, state_.nodes(), loads_.external(), state_.forces(), {}, message_) != SPRINGNET_OK)
      throw Error(ErrorKind::simulation, message_.text);
    forces_stale_ = false;
  }
  return state_;
}

// A node that starts on a surface with a force into it is held from the start.
void Engine::start_contacts() {
  const std::vector<Plane>& planes = contact_.planes();
  if (planes.empty()) return;
  double size = 0.0;
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k)
    for (const double* p : {state_.view.position.x, state_.view.position.y, state_.view.position.z})
      size = std::max(size, std::abs(p[k]));
  const double tolerance = 1e-9 * std::max(size, 1e-300);
  static_cast<void>(state());
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    if (contact_.fixed()[k] != 0) continue;
    const springnet_state& s = state_.view;
    const Vector3 position(s.position.x[k], s.position.y[k], s.position.z[k]);
    const Vector3 velocity(s.velocity.x[k], s.velocity.y[k], s.velocity.z[k]);
    const Vector3 force(s.force.x[k], s.force.y[k], s.force.z[k]);
    for (std::size_t j = 0; j < planes.size(); ++j) {
      const double distance = contact_.distance(j, position);
      if (distance < -tolerance)
        throw Error(ErrorKind::input,
                    fmt::format("node {} starts {} m behind plane '{}' (number {}), where no node can be; move the body "
                                "or the plane, or turn the plane's normal towards the body",
                                layout_.ordering().user[k], -distance, planes[j].name, j));
      if (distance > tolerance || planes[j].normal.dot(velocity) > 0.0) continue;
      if (planes[j].normal.dot(velocity) < 0.0 || planes[j].normal.dot(force) < 0.0) touch(k, j, 0.0, state_);
    }
  }
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
  const auto or_one = [](double value, double fallback) { return std::isfinite(value) && value > 0.0 ? value : fallback; };
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
  return SPRINGNET_OK;
}

void Engine::explain(double time, const layers::NodeArrays& nodes) {
  if (non_finite_.empty()) non_finite_ = explain_non_finite(layout_, evaluator_.instruction_set(), time, nodes);
}

namespace {

// What the finished tiles of an evaluation or a sweep need.
struct TileContext {
  const layers::Evaluator* evaluator;
  const springnet_sweep* sweep = nullptr;
  Contact* contact = nullptr;
  const std::vector<std::uint8_t>* constrained = nullptr;
  springnet_vectors acceleration{};
  double time;
  layers::NodeArrays nodes;
  layers::ForceArrays force;
  std::atomic<bool> finite{true};
  std::atomic<springnet_status> status{SPRINGNET_OK};
};

bool all_finite(const double* const force[3], std::uint32_t count) {
  double sum = 0.0;
  for (int c = 0; c < 3; ++c)
    for (std::uint32_t i = 0; i < count; ++i) sum += force[c][i] * 0.0;
  return sum == 0.0;
}

// Accelerations of a tile, then the integrator's update of its nodes, then fixation and contact.
void finish_tile(void* user, std::uint32_t unit, std::uint32_t first, std::uint32_t count) {
  TileContext& context = *static_cast<TileContext*>(user);
  const double* force[3] = {context.force.x + first, context.force.y + first, context.force.z + first};
  if (!all_finite(force, count)) context.finite.store(false, std::memory_order_relaxed);
  const bool in_place = context.sweep == nullptr;
  if (in_place && context.acceleration.x == nullptr) return;
  alignas(64) double local[3][layers::tile_nodes];
  double* acceleration[3] = {local[0], local[1], local[2]};
  if (in_place) {
    acceleration[0] = context.acceleration.x + first;
    acceleration[1] = context.acceleration.y + first;
    acceleration[2] = context.acceleration.z + first;
  }
  springnet_message message{};
  const springnet_status status = context.evaluator->accelerations(
      first, count, context.time, context.nodes, force, acceleration, nullptr, nullptr, nullptr, message);
  if (status != SPRINGNET_OK) {
    context.status.store(status, std::memory_order_relaxed);
    return;
  }
  if (in_place) {
    for (std::uint32_t i = 0; i < count; ++i)
      if ((*context.constrained)[first + i] != 0) acceleration[0][i] = acceleration[1][i] = acceleration[2][i] = 0.0;
    return;
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
}

}  // namespace

springnet_status Engine::evaluate(const springnet_evaluation& request) {
  TileContext context{};
  context.evaluator = &evaluator_;
  context.constrained = &contact_.constrained();
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
  springnet_status status = evaluator_.evaluate(request.time, context.nodes, loads_.external(), context.force,
                                                {finish_tile, &context}, message_);
  if (status == SPRINGNET_OK) status = context.status.load();
  if (status == SPRINGNET_OK && !context.finite.load()) {
    explain(request.time, context.nodes);
    set_message(message_, non_finite_);
    status = SPRINGNET_RECOVERABLE;
  }
  return status;
}

springnet_status Engine::evaluate_nodes(const springnet_evaluation& request, const std::uint32_t* nodes,
                                        std::uint32_t count) {
  const layers::FlushDenormals flush;
  const layers::NodeArrays arrays = node_arrays(request.position, request.velocity);
  const layers::ExternalForces external = loads_.external();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t k = nodes[i];
    Vector3 force;
    springnet_status status = evaluator_.evaluate_node(k, request.time, arrays, external, force, message_);
    if (status != SPRINGNET_OK) return status;
    if (request.force.x != nullptr) {
      request.force.x[k] = force[0];
      request.force.y[k] = force[1];
      request.force.z[k] = force[2];
    }
    if (request.acceleration.x == nullptr) continue;
    Vector3 a = Vector3::Zero();
    if (contact_.constrained()[k] == 0) {
      const double* f[3] = {&force[0], &force[1], &force[2]};
      double* const out[3] = {&a[0], &a[1], &a[2]};
      status = evaluator_.accelerations(k, 1, request.time, arrays, f, out, nullptr, nullptr, nullptr, message_);
      if (status != SPRINGNET_OK) return status;
    }
    request.acceleration.x[k] = a[0];
    request.acceleration.y[k] = a[1];
    request.acceleration.z[k] = a[2];
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
      if (status == SPRINGNET_OK) finish_tile(&context, 0, k, 1);
    }
  }
  if (status == SPRINGNET_OK) status = context.status.load();
  // The integrator sees for itself that the sweep diverged; the host remembers why.
  if (status == SPRINGNET_OK && !context.finite.load()) explain(sweep.time, context.nodes);
  return status;
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
  if (velocity) put(state_.view.velocity, *velocity);
  changed();
}

void Engine::set_fixed(std::uint32_t node, bool fixed) {
  contact_.set_fixed(node, fixed);
  set_node(node, std::nullopt, fixed ? std::optional<Vector3>(Vector3::Zero()) : std::nullopt);
}

}  // namespace springnet
