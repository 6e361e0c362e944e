// Sweeps: all springs before any node, tile by tile, or node by node in an order.

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include <springnet/sdk/message.hpp>

#include "constraints/cluster.hpp"
#include "constraints/vectors.hpp"
#include "profile/stage.hpp"
#include "simulation/sweep_tiles.hpp"

namespace springnet {
namespace {

bool all_finite(const layers::NodeDerivatives& derivatives) noexcept {
  const auto is_finite = [](double value) { return std::isfinite(value); };
  return std::all_of(std::begin(derivatives.by_velocity), std::end(derivatives.by_velocity), is_finite) &&
         std::all_of(std::begin(derivatives.by_position), std::end(derivatives.by_position), is_finite);
}

}  // namespace

springnet_status Sweep::run(const springnet_sweep& request, const springnet_network& network) {
  const springnet_sweep sweep = complete(request);
  const layers::SweepPlan* const plan = sweep.order == nullptr ? nullptr : plan_for(sweep, network);
  const std::shared_ptr<const Placement> at = model_.placement(sweep.time);
  const layers::ExternalForces external = model_.external_at(sweep.time);  // before threads ask for them
  note_done(sweep);
  struct Updating {
    bool &callback, &tiles;
    ~Updating() { callback = tiles = false; }
  } const updating{model_.in_callback, in_tiles_};
  const layers::InternalView internal = internal_of(sweep);
  model_.in_callback = true;
  in_tiles_ = sweep.order == nullptr;
  Tiles tiles{model_,
              at.get(),
              sweep.time,
              node_arrays(sweep.position, sweep.velocity, internal),
              {sweep.force.x, sweep.force.y, sweep.force.z},
              &sweep};
  springnet_message& message = model_.journal.message;
  springnet_status status = SPRINGNET_OK;
  if (sweep.order != nullptr) {
    status = in_order(tiles, plan);
  } else {
    status = model_.evaluator.evaluate(sweep.time, tiles.nodes, external, tiles.force, {finish_tile, &tiles}, message);
    if (status == SPRINGNET_OK && model_.rigid.cluster_count() > 0) {
      const profile::Stage stage("rigid");
      status = model_.constraints.constrain_clusters(*at, sweep, model_.evaluator.threads(), message);
    }
  }
  if (status == SPRINGNET_OK) pairs_.constrain(sweep, false);
  const bool left =
      status == SPRINGNET_OK && sweep.order == nullptr && model_.rigid.cluster_count() == 0 && tiles.outputs_finite;
  left_position_ = left ? sweep.next_position.x : nullptr;
  left_velocity_ = left ? sweep.next_velocity.x : nullptr;
  if (status != SPRINGNET_OK) return model_.failed(status, sweep.time, tiles.nodes);
  // The integrator detects that the sweep diverged; the journal keeps the reason.
  static_cast<void>(check_finite(tiles.finite, tiles.bad_neuron, sweep.time, tiles.nodes));
  return SPRINGNET_OK;
}

// With an order each node evaluates the states of its own springs, with outputs that others will still change.
layers::InternalView Sweep::internal_of(const springnet_sweep& sweep) {
  layers::InternalView view = model_.internal_for(sweep.internal);
  if (sweep.order != nullptr) view.next = view.rates = nullptr;
  return view;
}

springnet_status Sweep::constrain(const springnet_sweep& request) {
  const springnet_sweep sweep = complete(request);
  const std::shared_ptr<const Placement> at = model_.placement(sweep.time);
  note_done(sweep);
  model_.constraints.push(0, model_.node_count(), sweep);
  model_.constraints.remember_contacts(sweep);
  if (sweep.contacts == SPRINGNET_AS_BEFORE || sweep.contacts == SPRINGNET_MAY_TOUCH) pairs_.take_out(sweep);
  model_.constraints.constrain(*at, 0, model_.node_count(), sweep);
  springnet_sweep of_clusters = sweep;
  if (of_clusters.contacts == SPRINGNET_MAY_TOUCH) of_clusters.contacts = 0;
  const springnet_status status =
      model_.constraints.constrain_clusters(*at, of_clusters, model_.evaluator.threads(), model_.journal.message);
  if (status == SPRINGNET_OK) model_.constraints.limit_changes(*at, sweep);
  if (sweep.contacts == SPRINGNET_AS_BEFORE)
    pairs_.put_back(sweep);  // they stay as they are, too
  else if (status == SPRINGNET_OK)
    pairs_.constrain(sweep, true);
  return status;
}

void Sweep::note_done(const springnet_sweep& sweep) noexcept {
  const double weight = sweep.time_constant * (sweep.theta > 0.0 ? sweep.theta : 1.0);
  done_ = {true, sweep.contacts != 1, weight, sweep.time_constant - weight};
}

// Forces on a node at the newest outputs.
springnet_status Sweep::evaluate_node(std::uint32_t node, Tiles& tiles, NodeEvaluation& result,
                                      springnet_message& message) {
  const layers::ExternalForces external = model_.external_at(tiles.time);
  Vector3 force, acceleration;
  const springnet_status status =
      tiles.sweep->want_blocks != 0
          ? model_.evaluator.evaluate_node(node, tiles.time, tiles.nodes, external, &swept_volumes_, force,
                                           acceleration, &result.derivatives, nullptr, message)
          : model_.evaluator.evaluate_node(node, tiles.time, tiles.nodes, external, &swept_volumes_, force, message);
  tiles.force.x[node] = force[0];
  tiles.force.y[node] = force[1];
  tiles.force.z[node] = force[2];
  if (status != SPRINGNET_OK) return status;
  result.finite = force.allFinite();
  if (!result.finite) {
    tiles.finite.store(false, std::memory_order_relaxed);
    // Explain before the node's update, which makes its own outputs not finite, too; but not while other threads write
    // outputs.
    if (!in_sets_) model_.explain(tiles.time, tiles.nodes);
  } else if (tiles.sweep->want_blocks != 0 && !in_sets_ && !all_finite(result.derivatives)) {
    // The update will not be finite.
    model_.explain(tiles.time, tiles.nodes, layers::Requested::forces_and_derivatives);
  }
  return SPRINGNET_OK;
}

springnet_status Sweep::update_node(std::uint32_t node, std::uint32_t unit, Tiles& tiles,
                                    const NodeEvaluation& evaluation, springnet_message& message) {
  const double* const force[3] = {tiles.force.x + node, tiles.force.y + node, tiles.force.z + node};
  return tiles.update(unit, node, 1, force, evaluation.finite,
                      tiles.sweep->want_blocks != 0 ? &evaluation.derivatives : nullptr, message);
}

// Nodes that do not read one another: all are evaluated, then all are updated. That is what a sweep in their order
// does, and costs one call of a law for all their springs.
springnet_status Sweep::together(const layers::NodeList& list, std::uint32_t unit, Tiles& tiles,
                                 springnet_message& message) {
  const profile::Tile measured;
  const std::span<const std::uint32_t> nodes = list.nodes;
  alignas(64) double forces[3][layers::together_limit], accelerations[3][layers::together_limit];
  double* const force[3] = {forces[0], forces[1], forces[2]};
  double* const acceleration[3] = {accelerations[0], accelerations[1], accelerations[2]};
  layers::ListedNodes own;  // not initialised: written before it is read
  model_.evaluator.copy(nodes, tiles.nodes, own);
  springnet_status status = model_.evaluator.evaluate_together(list, own, tiles.time, tiles.nodes,
                                                               model_.external_at(tiles.time), nullptr, force, message);
  if (status != SPRINGNET_OK) return status;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::uint32_t k = nodes[i];
    tiles.force.x[k] = force[0][i];
    tiles.force.y[k] = force[1][i];
    tiles.force.z[k] = force[2][i];
  }
  if (!tiles.all_finite(force, static_cast<std::uint32_t>(nodes.size()))) {
    tiles.finite.store(false, std::memory_order_relaxed);
    // As in evaluate_node().
    if (!in_sets_) model_.explain(tiles.time, tiles.nodes);
  }
  status = model_.evaluator.accelerations(nodes, own, tiles.time, force, acceleration, message);
  if (status != SPRINGNET_OK) return status;
  tiles.note_bad_neurons(nodes, force, acceleration);
  return tiles.update(unit, nodes, own, force, acceleration, message);
}

// The end of the run of nodes from order[begin] on that can be evaluated together, at least begin + 1 if any can;
// `begin` if order[begin] must be evaluated by itself.
std::uint32_t Sweep::end_of_run(std::uint32_t begin, std::uint32_t end, Turn turn, const Tiles& tiles) {
  const springnet_sweep& sweep = *tiles.sweep;
  if (sweep.want_blocks != 0 || turn == Turn::on_enclosure) return begin;
  end = std::min(end, begin + static_cast<std::uint32_t>(layers::together_limit));
  std::uint32_t i = begin;
  if (sweep.set_start != nullptr) {  // no two nodes of a set are joined
    while (i < end && is_local(sweep.order[i])) ++i;
    return i;
  }
  const std::vector<std::uint32_t>& start = model_.layout.neighbour_start();
  const std::vector<std::uint32_t>& neighbours = model_.layout.neighbours();
  run_of_.resize(model_.node_count(), 0);
  if (++run_ == 0) {  // overflow
    std::fill(run_of_.begin(), run_of_.end(), 0);
    run_ = 1;
  }
  for (; i < end; ++i) {
    const std::uint32_t k = sweep.order[i];
    if (!is_local(k)) break;
    bool reads_run = false;
    for (std::uint32_t n = start[k]; n < start[k + 1]; ++n) reads_run |= run_of_[neighbours[n]] == run_;
    if (reads_run) break;
    run_of_[k] = run_;
  }
  return i;
}

bool Sweep::is_local(std::uint32_t node) const {
  const std::uint32_t* clusters = model_.rigid.cluster_of();
  return (clusters == nullptr || clusters[node] == no_cluster) && !is_on_enclosure(node);
}

// A plan costs as much as it saves in one sweep of a net whose nodes come in short runs, and lasts while its order
// comes again.
const layers::SweepPlan* Sweep::plan_for(const springnet_sweep& sweep, const springnet_network& network) {
  const bool suits = sweep.lists != 0 && sweep.set_start == nullptr && sweep.want_blocks == 0;
  const std::span<const std::uint32_t> order(sweep.order, sweep.order_count);
  if (suits)
    if (const layers::SweepPlan* known = plans_.find(model_.layout, order)) return known;
  order_check_.check(sweep, network, model_.layout);
  if (!suits) return nullptr;
  const profile::Stage stage("plan");
  return plans_.make(model_.layout, order, [this](std::uint32_t k) { return is_local(k); });
}

springnet_status Sweep::by_plan(const layers::SweepPlan& plan, Tiles& tiles, springnet_message& message) {
  for (const layers::SweepPlan::Stage& stage : plan.stages()) {
    const springnet_status status = stage.is_single ? one(stage.nodes.front(), 0, Turn::all, tiles, message)
                                                    : together({stage.nodes, stage.springs}, 0, tiles, message);
    if (status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

// All nodes of a cluster are evaluated before any is updated: with only some updated, outputs do not satisfy the
// connections.
springnet_status Sweep::cluster(std::size_t cluster, std::uint32_t unit, Tiles& tiles, springnet_message& message) {
  const std::vector<std::uint32_t>& nodes = model_.rigid.nodes_of(cluster);
  std::vector<NodeEvaluation> evaluations(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (const springnet_status status = evaluate_node(nodes[i], tiles, evaluations[i], message); status != SPRINGNET_OK)
      return status;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (const springnet_status status = update_node(nodes[i], unit, tiles, evaluations[i], message);
        status != SPRINGNET_OK)
      return status;
  return model_.constraints.constrain_cluster(*tiles.at, cluster, *tiles.sweep, message);
}

// Whether a node, or a node of its cluster, lies on an enclosure, all of whose nodes depend on each other.
bool Sweep::is_on_enclosure(std::uint32_t node) const {
  const layers::ElementLayout& elements = model_.layout.elements();
  if (elements.live_enclosures() == 0) return false;
  const auto on_enclosure = [&](std::uint32_t k) {
    const std::span<const layers::ElementShare> shares = elements.shares(k);
    return !shares.empty() && shares.back().enclosure != layers::no_enclosure;
  };
  const std::uint32_t* clusters = model_.rigid.cluster_of();
  if (clusters == nullptr || clusters[node] == no_cluster) return on_enclosure(node);
  const std::vector<std::uint32_t>& members = model_.rigid.nodes_of(clusters[node]);
  return std::any_of(members.begin(), members.end(), on_enclosure);
}

// A node by itself; a cluster in the place of its first node.
springnet_status Sweep::one(std::uint32_t node, std::uint32_t unit, Turn turn, Tiles& tiles,
                            springnet_message& message) {
  const std::uint32_t* clusters = model_.rigid.cluster_of();
  const bool has_enclosures = model_.layout.elements().live_enclosures() > 0;
  if (has_enclosures && turn != Turn::all && is_on_enclosure(node) != (turn == Turn::on_enclosure)) return SPRINGNET_OK;
  const bool commits = has_enclosures && turn != Turn::others;
  const std::uint32_t cluster = clusters == nullptr ? no_cluster : clusters[node];
  springnet_status status = SPRINGNET_OK;
  const profile::Tile measured;
  if (cluster == no_cluster) {
    NodeEvaluation evaluation;
    status = evaluate_node(node, tiles, evaluation, message);
    if (status == SPRINGNET_OK) status = update_node(node, unit, tiles, evaluation, message);
    if (commits) swept_volumes_.commit(node);
  } else if (tiles.sweep->set_start != nullptr ? node == model_.rigid.nodes_of(cluster).front()
                                               : cluster_done_[cluster] == 0) {
    cluster_done_[cluster] = 1;
    status = this->cluster(cluster, unit, tiles, message);
    if (commits)
      for (const std::uint32_t member : model_.rigid.nodes_of(cluster)) swept_volumes_.commit(member);
  }
  return status;
}

// Nodes [begin, end) of the order, one after another.
springnet_status Sweep::range(std::uint32_t begin, std::uint32_t end, std::uint32_t unit, Turn turn, Tiles& tiles,
                              springnet_message& message) {
  const std::uint32_t* order = tiles.sweep->order;
  for (std::uint32_t i = begin; i < end;) {
    const std::uint32_t stop = end_of_run(i, end, turn, tiles);
    const springnet_status status =
        stop > i ? together({{order + i, stop - i}}, unit, tiles, message) : one(order[i], unit, turn, tiles, message);
    if (status != SPRINGNET_OK) return status;
    i = std::max(stop, i + 1);
  }
  return SPRINGNET_OK;
}

// One set of a sweep: nodes that depend only on their neighbours by several threads, then the nodes of enclosures one
// after another.
springnet_status Sweep::one_set(std::uint32_t set, Tiles& tiles) {
  const springnet_sweep& sweep = *tiles.sweep;
  // Nodes of a set are sorted, so those of a unit of the layout are adjacent; one thread at a time works on a unit.
  const std::vector<layers::Unit>& units = model_.layout.units();
  const auto unit_count = static_cast<std::int64_t>(units.size());
  const std::uint32_t* begin = sweep.order + sweep.set_start[set];
  const std::uint32_t* end = sweep.order + sweep.set_start[set + 1];
  std::int64_t failed_unit = unit_count;
  springnet_status failure = SPRINGNET_OK;
  in_sets_ = true;
  {
    const profile::Region region(model_.evaluator.threads());
#pragma omp parallel num_threads(static_cast <int>(model_.evaluator.threads()))
    {
      const profile::Share share(region, omp_get_thread_num(), omp_get_num_threads());
#pragma omp for schedule(dynamic, 1) nowait
      for (std::int64_t u = 0; u < unit_count; ++u) {
        const layers::FlushDenormals flush;
        const layers::Unit& unit = units[static_cast<std::size_t>(u)];
        const auto first = static_cast<std::uint32_t>(std::lower_bound(begin, end, unit.first_node) - sweep.order);
        const auto last =
            static_cast<std::uint32_t>(std::lower_bound(begin, end, unit.first_node + unit.node_count) - sweep.order);
        springnet_message message{};
        // An exception that leaves the region would end the process.
        const springnet_status status = sdk::detail::guarded(
            &message, [&] { return range(first, last, static_cast<std::uint32_t>(u), Turn::others, tiles, message); });
        if (status == SPRINGNET_OK) continue;
        const std::lock_guard guard(model_.journal.failure_lock);
        if (u < failed_unit) {
          failed_unit = u;
          failure = status;
          model_.journal.message = message;
        }
      }
    }
  }
  in_sets_ = false;
  if (failure != SPRINGNET_OK || model_.layout.elements().live_enclosures() == 0) return failure;
  const layers::FlushDenormals flush;
  return range(sweep.set_start[set], sweep.set_start[set + 1], 0, Turn::on_enclosure, tiles, model_.journal.message);
}

springnet_status Sweep::in_order(Tiles& tiles, const layers::SweepPlan* plan) {
  model_.layout.need_incidence();  // before threads do
  const springnet_sweep& sweep = *tiles.sweep;
  cluster_done_.assign(model_.rigid.cluster_count(), 0);
  struct Following {
    layers::EnclosureVolumes& volumes;
    ~Following() { volumes.stop(); }
  } const following{swept_volumes_};
  const layers::FlushDenormals flush;
  if (model_.layout.elements().live_enclosures() > 0) swept_volumes_.follow(model_.layout.elements(), tiles.nodes);
  if (plan != nullptr) return by_plan(*plan, tiles, model_.journal.message);
  if (sweep.set_start == nullptr) return range(0, sweep.order_count, 0, Turn::all, tiles, model_.journal.message);
  for (std::uint32_t set = 0; set < sweep.set_count; ++set) {
    if (const springnet_status status = one_set(set, tiles); status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet
