// Evaluations and sweeps on behalf of an integrator: springs, loads and neurons, then what holds nodes.

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <mutex>

#include "constraints/vectors.hpp"
#include "layers/springs/queries.hpp"
#include "plugin_host/message.hpp"
#include "simulation/engine.hpp"

namespace springnet {
namespace {

constexpr std::uint32_t no_node = 0xffffffffu, no_cluster = 0xffffffffu;

// What the finished tiles of an evaluation or a sweep need.
struct TileContext {
  const layers::Evaluator* evaluator;
  const springnet_sweep* sweep = nullptr;
  ConstraintSet* constraints = nullptr;
  const Placement* at = nullptr;  // surfaces at `time`
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

// Accelerations of a tile; within an evaluation what they become where something holds the nodes.
springnet_status accelerate_tile(TileContext& context, std::uint32_t first, std::uint32_t count, bool finite,
                                 springnet_message& message) {
  const double* force[3] = {context.force.x + first, context.force.y + first, context.force.z + first};
  double* acceleration[3] = {context.acceleration.x + first, context.acceleration.y + first,
                             context.acceleration.z + first};
  const springnet_status status = context.evaluator->accelerations(first, count, context.time, context.nodes, force,
                                                                   acceleration, nullptr, nullptr, nullptr, message);
  if (status != SPRINGNET_OK) return status;
  if (finite && !all_finite(acceleration, count)) note_bad_neuron(context, first, count, acceleration);
  context.constraints->accelerate(*context.at, first, count, {context.nodes.px, context.nodes.py, context.nodes.pz},
                                  {context.nodes.vx, context.nodes.vy, context.nodes.vz}, acceleration);
  return SPRINGNET_OK;
}

// The integrator's own function, which must not throw; what it throws all the same ends the sweep.
springnet_status call_update(const springnet_sweep& sweep, const springnet_node_batch& batch,
                             springnet_message& message) noexcept {
  try {
    sweep.update(sweep.user, &batch);
    return SPRINGNET_OK;
  } catch (const std::exception& error) {
    char text[2 * sizeof message.text];
    std::snprintf(text, sizeof text, "the integrator's update of nodes threw an exception: %s", error.what());
    sdk::detail::write_message(&message, text);
  } catch (...) {
    sdk::detail::write_message(&message, "the integrator's update of nodes threw something that is no std::exception");
  }
  return SPRINGNET_FAILED;
}

// The integrator's update of nodes, then fixation and contact.
springnet_status update_tile(TileContext& context, std::uint32_t unit, std::uint32_t first, std::uint32_t count,
                             bool finite, const layers::NodeDerivatives* derivatives, springnet_message& message) {
  const double* force[3] = {context.force.x + first, context.force.y + first, context.force.z + first};
  alignas(64) double local[3][layers::tile_nodes];
  double* acceleration[3] = {local[0], local[1], local[2]};
  const springnet_status status = context.evaluator->accelerations(first, count, context.time, context.nodes, force,
                                                                   acceleration, nullptr, nullptr, nullptr, message);
  if (status != SPRINGNET_OK) return status;
  if (finite && !all_finite(acceleration, count)) note_bad_neuron(context, first, count, acceleration);
  springnet_node_batch batch{};
  batch.struct_size = sizeof batch;
  batch.first = first;
  batch.count = count;
  batch.unit = unit;
  batch.force = {force[0], force[1], force[2]};
  batch.acceleration = {acceleration[0], acceleration[1], acceleration[2]};
  if (derivatives != nullptr) {
    batch.acceleration_by_velocity = derivatives->by_velocity;
    batch.acceleration_by_position = derivatives->by_position;
  }
  // What an update starts from; tile by tile that stays where it is.
  Vector3 read = Vector3::Zero();
  const bool in_place = count == 1 && context.sweep->order != nullptr;
  if (in_place) read = {context.nodes.vx[first], context.nodes.vy[first], context.nodes.vz[first]};
  if (const springnet_status updated = call_update(*context.sweep, batch, message); updated != SPRINGNET_OK)
    return updated;
  context.constraints->constrain(*context.at, first, count, *context.sweep, in_place ? &read : nullptr);
  return SPRINGNET_OK;
}

springnet_status finish_tile(void* user, std::uint32_t unit, std::uint32_t first, std::uint32_t count,
                             springnet_message& message) {
  TileContext& context = *static_cast<TileContext*>(user);
  const double* force[3] = {context.force.x + first, context.force.y + first, context.force.z + first};
  const bool finite = all_finite(force, count);
  if (!finite) context.finite.store(false, std::memory_order_relaxed);
  if (context.sweep != nullptr) return update_tile(context, unit, first, count, finite, nullptr, message);
  if (context.acceleration.x == nullptr) return SPRINGNET_OK;
  return accelerate_tile(context, first, count, finite, message);
}

bool all_finite(const layers::NodeDerivatives& derivatives) noexcept {
  const auto is_finite = [](double value) { return std::isfinite(value); };
  return std::all_of(std::begin(derivatives.by_velocity), std::end(derivatives.by_velocity), is_finite) &&
         std::all_of(std::begin(derivatives.by_position), std::end(derivatives.by_position), is_finite);
}

// A request as this host knows it, whatever the integrator was compiled against.
springnet_sweep complete(const springnet_sweep& request) {
  springnet_sweep sweep{};
  std::memcpy(&sweep, &request, std::min<std::size_t>(sizeof sweep, request.struct_size));
  sweep.struct_size = sizeof sweep;
  return sweep;
}

}  // namespace

void Engine::explain(double time, const layers::NodeArrays& nodes, layers::Asked asked) {
  if (non_finite_.empty()) non_finite_ = explain_failure(layout_, evaluator_.instruction_set(), time, nodes, asked);
}

// What is known of an evaluation that a law or a neuron ended: which spring it was, if it was a law.
springnet_status Engine::failed(springnet_status status, double time, const layers::NodeArrays& nodes) {
  const std::string reason = explain_failure(layout_, evaluator_.instruction_set(), time, nodes);
  if (!reason.empty()) set_message(message_, reason);
  non_finite_ = message_.text;
  return status;
}

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
  const std::shared_ptr<const Placement> at = placement(request.time);
  TileContext context{};
  context.at = at.get();
  context.evaluator = &evaluator_;
  context.constraints = &constraints_;
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
  const springnet_status status = evaluator_.evaluate(request.time, context.nodes, external_at(request.time),
                                                      context.force, {finish_tile, &context}, message_);
  if (status != SPRINGNET_OK) return failed(status, request.time, context.nodes);
  if (!check_finite(context.finite, context.bad_neuron, request.time, context.nodes)) {
    set_message(message_, non_finite_);
    return SPRINGNET_RECOVERABLE;
  }
  if (request.acceleration.x != nullptr)
    constraints_.accelerate_clusters(*at, request.position, request.velocity, request.acceleration);
  return SPRINGNET_OK;
}

springnet_status Engine::evaluate_nodes(const springnet_evaluation& request, const std::uint32_t* nodes,
                                        std::uint32_t count) {
  springnet_evaluation wanted{};
  std::memcpy(&wanted, &request, std::min<std::size_t>(sizeof wanted, request.struct_size));
  const layers::FlushDenormals flush;
  const layers::NodeArrays arrays = node_arrays(wanted.position, wanted.velocity);
  const layers::ExternalForces external = external_at(wanted.time);  // the same for all threads of a sweep
  const layers::EnclosureVolumes* volumes = nullptr;
  if (layout_.elements().live_enclosures() > 0) {
    if (swept_volumes_.follows(arrays)) {
      volumes = &swept_volumes_;
    } else if (!in_sets_ && !in_tiles_) {
      asked_volumes_.compute(layout_.elements(), arrays);
      volumes = &asked_volumes_;
    }
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t k = nodes[i];
    Vector3 force, a = Vector3::Zero();
    layers::NodeDerivatives derivatives;
    const bool blocks = wanted.acceleration_by_velocity != nullptr || wanted.acceleration_by_position != nullptr;
    springnet_message message{};
    const springnet_status status =
        wanted.acceleration.x == nullptr && !blocks && wanted.energy == nullptr
            ? evaluator_.evaluate_node(k, wanted.time, arrays, external, volumes, force, message)
            : evaluator_.evaluate_node(k, wanted.time, arrays, external, volumes, force, a,
                                       blocks ? &derivatives : nullptr,
                                       wanted.energy == nullptr ? nullptr : wanted.energy + k, message);
    if (status != SPRINGNET_OK) {
      const std::lock_guard guard(failure_lock_);
      message_ = message;
      return in_sets_ ? status : failed(status, wanted.time, arrays);
    }
    if (!force.allFinite() || !a.allFinite()) {
      const std::lock_guard guard(failure_lock_);
      if (!in_sets_) static_cast<void>(check_finite(force.allFinite(), k, wanted.time, arrays));
      set_message(message_, non_finite_);
      return SPRINGNET_RECOVERABLE;
    }
    if (wanted.force.x != nullptr) put_vector(wanted.force, k, force);
    if (wanted.acceleration.x != nullptr) put_vector(wanted.acceleration, k, a);
    if (wanted.acceleration_by_velocity != nullptr)
      std::copy_n(derivatives.by_velocity, 9, wanted.acceleration_by_velocity + 9 * std::size_t{k});
    if (wanted.acceleration_by_position != nullptr)
      std::copy_n(derivatives.by_position, 9, wanted.acceleration_by_position + 9 * std::size_t{k});
  }
  return SPRINGNET_OK;
}

struct Engine::NodeEvaluation {
  layers::NodeDerivatives derivatives;
  bool finite;
};

// A node's springs at the newest outputs.
springnet_status Engine::evaluate_for_update(std::uint32_t node, void* tile_context, NodeEvaluation& result,
                                             springnet_message& message) {
  TileContext& context = *static_cast<TileContext*>(tile_context);
  const layers::ExternalForces external = external_at(context.time);
  Vector3 force, acceleration;
  const springnet_status status =
      context.sweep->want_blocks != 0
          ? evaluator_.evaluate_node(node, context.time, context.nodes, external, &swept_volumes_, force, acceleration,
                                     &result.derivatives, nullptr, message)
          : evaluator_.evaluate_node(node, context.time, context.nodes, external, &swept_volumes_, force, message);
  context.force.x[node] = force[0];
  context.force.y[node] = force[1];
  context.force.z[node] = force[2];
  if (status != SPRINGNET_OK) return status;
  result.finite = force.allFinite();
  if (!result.finite) {
    context.finite.store(false, std::memory_order_relaxed);
    // Before its update: afterwards the node's own outputs would not be finite either. Not while other threads write
    // theirs.
    if (!in_sets_) explain(context.time, context.nodes);
  } else if (context.sweep->want_blocks != 0 && !in_sets_ && !all_finite(result.derivatives)) {
    explain(context.time, context.nodes, layers::Asked::forces_and_derivatives);  // the update will not be finite
  }
  return SPRINGNET_OK;
}

// Then its update.
springnet_status Engine::update_node(std::uint32_t node, std::uint32_t unit, void* tile_context,
                                     const NodeEvaluation& evaluation, springnet_message& message) {
  TileContext& context = *static_cast<TileContext*>(tile_context);
  return update_tile(context, unit, node, 1, evaluation.finite,
                     context.sweep->want_blocks != 0 ? &evaluation.derivatives : nullptr, message);
}

// All nodes of a cluster read outputs that fit its connections, which those of its first nodes do not before the end.
springnet_status Engine::update_cluster(std::size_t cluster, std::uint32_t unit, void* tile_context,
                                        springnet_message& message) {
  const std::vector<std::uint32_t>& nodes = rigid_.nodes_of(cluster);
  std::vector<NodeEvaluation> evaluations(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (const springnet_status status = evaluate_for_update(nodes[i], tile_context, evaluations[i], message);
        status != SPRINGNET_OK)
      return status;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (const springnet_status status = update_node(nodes[i], unit, tile_context, evaluations[i], message);
        status != SPRINGNET_OK)
      return status;
  const TileContext& context = *static_cast<TileContext*>(tile_context);
  return constraints_.constrain_cluster(*context.at, cluster, *context.sweep, message);
}

// Whether a node, or one of its cluster, is one of a closed surface, whose nodes all see each other.
bool Engine::is_joined_to_all(std::uint32_t node) const {
  const layers::ElementLayout& elements = layout_.elements();
  if (elements.live_enclosures() == 0) return false;
  const auto on_surface = [&](std::uint32_t k) {
    const std::span<const layers::ElementShare> shares = elements.shares(k);
    return !shares.empty() && shares.back().enclosure != layers::no_enclosure;
  };
  const std::uint32_t* clusters = rigid_.cluster_of();
  if (clusters == nullptr || clusters[node] == no_cluster) return on_surface(node);
  const std::vector<std::uint32_t>& members = rigid_.nodes_of(clusters[node]);
  return std::any_of(members.begin(), members.end(), on_surface);
}

// Nodes [begin, end) of the order, one after another; a cluster when the first of its nodes has its turn.
springnet_status Engine::update_range(std::uint32_t begin, std::uint32_t end, std::uint32_t unit, Turn turn,
                                      void* tile_context, springnet_message& message) {
  const springnet_sweep& sweep = *static_cast<TileContext*>(tile_context)->sweep;
  const std::uint32_t* clusters = rigid_.cluster_of();
  const bool surfaces = layout_.elements().live_enclosures() > 0;
  for (std::uint32_t i = begin; i < end; ++i) {
    const std::uint32_t k = sweep.order[i];
    if (surfaces && turn != Turn::all && is_joined_to_all(k) != (turn == Turn::joined_to_all)) continue;
    const std::uint32_t cluster = clusters == nullptr ? no_cluster : clusters[k];
    springnet_status status = SPRINGNET_OK;
    if (cluster == no_cluster) {
      NodeEvaluation evaluation;
      status = evaluate_for_update(k, tile_context, evaluation, message);
      if (status == SPRINGNET_OK) status = update_node(k, unit, tile_context, evaluation, message);
      if (surfaces && turn != Turn::others) swept_volumes_.commit(k);
    } else if (sweep.set_start != nullptr ? k == rigid_.nodes_of(cluster).front() : cluster_done_[cluster] == 0) {
      cluster_done_[cluster] = 1;
      status = update_cluster(cluster, unit, tile_context, message);
      if (surfaces && turn != Turn::others)
        for (const std::uint32_t member : rigid_.nodes_of(cluster)) swept_volumes_.commit(member);
    }
    if (status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

// One set of a sweep: by threads what sees none but its neighbours, then one after another the nodes of closed
// surfaces.
springnet_status Engine::sweep_set(std::uint32_t set, void* tile_context) {
  const springnet_sweep& sweep = *static_cast<TileContext*>(tile_context)->sweep;
  // A set's nodes rise, so those of a unit of the layout stand together; a unit belongs to one thread at a time.
  const std::vector<layers::Unit>& units = layout_.units();
  const auto unit_count = static_cast<std::int64_t>(units.size());
  const std::uint32_t* begin = sweep.order + sweep.set_start[set];
  const std::uint32_t* end = sweep.order + sweep.set_start[set + 1];
  std::int64_t failed_unit = unit_count;
  springnet_status failure = SPRINGNET_OK;
  in_sets_ = true;
#pragma omp parallel for schedule(dynamic, 1) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t u = 0; u < unit_count; ++u) {
    const layers::FlushDenormals flush;
    const layers::Unit& unit = units[static_cast<std::size_t>(u)];
    const auto first = static_cast<std::uint32_t>(std::lower_bound(begin, end, unit.first_node) - sweep.order);
    const auto last =
        static_cast<std::uint32_t>(std::lower_bound(begin, end, unit.first_node + unit.node_count) - sweep.order);
    springnet_message message{};
    // An exception that leaves the region would end the process.
    const springnet_status status = sdk::detail::guarded(&message, [&] {
      return update_range(first, last, static_cast<std::uint32_t>(u), Turn::others, tile_context, message);
    });
    if (status == SPRINGNET_OK) continue;
    const std::lock_guard guard(failure_lock_);
    if (u < failed_unit) {
      failed_unit = u;
      failure = status;
      message_ = message;
    }
  }
  in_sets_ = false;
  if (failure != SPRINGNET_OK || layout_.elements().live_enclosures() == 0) return failure;
  const layers::FlushDenormals flush;
  return update_range(sweep.set_start[set], sweep.set_start[set + 1], 0, Turn::joined_to_all, tile_context, message_);
}

springnet_status Engine::sweep_in_order(const springnet_sweep& sweep, void* tile_context) {
  cluster_done_.assign(rigid_.cluster_count(), 0);
  struct Following {
    layers::EnclosureVolumes& volumes;
    ~Following() { volumes.stop(); }
  } const following{swept_volumes_};
  const layers::FlushDenormals flush;
  if (layout_.elements().live_enclosures() > 0)
    swept_volumes_.follow(layout_.elements(), static_cast<TileContext*>(tile_context)->nodes);
  if (sweep.set_start == nullptr) return update_range(0, sweep.order_count, 0, Turn::all, tile_context, message_);
  for (std::uint32_t set = 0; set < sweep.set_count; ++set) {
    if (const springnet_status status = sweep_set(set, tile_context); status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

void Engine::note_sweep(const springnet_sweep& sweep) noexcept {
  swept_ = true;
  swept_decided_ = sweep.contacts == 0;
  swept_weight_ = sweep.time_constant * (sweep.theta > 0.0 ? sweep.theta : 1.0);
  swept_rest_ = sweep.time_constant - swept_weight_;
}

springnet_status Engine::sweep(const springnet_sweep& request) {
  const springnet_sweep sweep = complete(request);
  if (sweep.order != nullptr) order_check_.check(sweep, network_info());
  const std::shared_ptr<const Placement> at = placement(sweep.time);
  static_cast<void>(external_at(sweep.time));  // before threads ask for them
  note_sweep(sweep);
  struct Updating {
    bool &sweep, &tiles;
    ~Updating() { sweep = tiles = false; }
  } const updating{in_sweep_, in_tiles_};
  in_sweep_ = true;
  in_tiles_ = sweep.order == nullptr;
  TileContext context{};
  context.evaluator = &evaluator_;
  context.sweep = &sweep;
  context.at = at.get();
  context.constraints = &constraints_;
  context.time = sweep.time;
  context.nodes = node_arrays(sweep.position, sweep.velocity);
  context.force = {sweep.force.x, sweep.force.y, sweep.force.z};
  if (sweep.order != nullptr) {
    const springnet_status status = sweep_in_order(sweep, &context);
    if (status != SPRINGNET_OK) return failed(status, sweep.time, context.nodes);
  } else {
    springnet_status status = evaluator_.evaluate(sweep.time, context.nodes, external_at(sweep.time), context.force,
                                                  {finish_tile, &context}, message_);
    if (status != SPRINGNET_OK) return failed(status, sweep.time, context.nodes);
    status = constraints_.constrain_clusters(*at, sweep, evaluator_.threads(), message_);
    if (status != SPRINGNET_OK) return failed(status, sweep.time, context.nodes);
  }
  // The integrator sees for itself that the sweep diverged; the host remembers why.
  static_cast<void>(check_finite(context.finite, context.bad_neuron, sweep.time, context.nodes));
  return SPRINGNET_OK;
}

springnet_status Engine::constrain(const springnet_sweep& request) {
  const springnet_sweep sweep = complete(request);
  if (sweep.contacts > 1) return step_explicitly(sweep);
  const std::shared_ptr<const Placement> at = placement(sweep.time);
  note_sweep(sweep);
  constraints_.constrain(*at, 0, layout_.node_count(), sweep);
  return constraints_.constrain_clusters(*at, sweep, evaluator_.threads(), message_);
}

}  // namespace springnet
