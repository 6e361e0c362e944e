// Applies surfaces and rigid connections to the outputs of Newton's method.
#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "block_update.hpp"
#include "columns.hpp"
#include "newton.hpp"

namespace springnet::recurrent {
namespace {

// Corrections this small, relative to the positions, are rounding.
constexpr double negligible = 1e-14;
// To test for separation, held nodes may be moved at least this far, in units of the length scale.
constexpr double min_move_limit = 1e-3;
// After so many sweeps of a step that change contacts, those there are stay until the residual is this share of what
// the last change left of it, or this many times the tolerance; but for no more sweeps than these.
constexpr std::uint64_t patience_with_releases = 3;
constexpr double share_of_change = 0.05, margin_of_release = 10.0;
constexpr std::uint64_t max_sweeps_between = 5;
// Of the way that its own equation would take a node that slides whatever the forces.
constexpr double share_of_kept = 1e-3;
// After this many sweeps of a step that change contacts, held nodes stay where they are.
constexpr std::uint64_t patience = 6;

// Outputs that differ by more than rounding: of any node, and of one that does not slide.
struct Differing {
  bool any = false, beside_sliding = false;
  void add(const springnet_vectors& a, const springnet_vectors& b, const std::vector<std::uint8_t>& status) noexcept {
    double size = 0.0, difference = 0.0, beside = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double *first = axes(a)[axis], *second = axes(b)[axis];
      for (std::size_t k = 0; k < status.size(); ++k) {
        size = std::max(size, std::abs(first[k]));
        const double own = std::abs(first[k] - second[k]);
        difference = std::max(difference, own);
        if (status[k] != SPRINGNET_SLIDING) beside = std::max(beside, own);
      }
    }
    any = any || !(difference <= negligible * size);
    beside_sliding = beside_sliding || !(beside <= negligible * size);
  }
};

}  // namespace

// Far from the solution of the contacts as they are, none is released or begins to slip; but not where bodies push
// nodes, which obstacles have to give way to.
bool Newton::waits_with_releases(const Step& step, const springnet_state* before) const {
  const springnet_network& network = step.network;
  if (network.surface_count == 0 || network.rigid_count > 0 || before == nullptr || !step.decides || step.waits ||
      step.is_pushed())
    return false;
  return contact_changes_ >= patience_with_releases && step.sweeps < last_switch_ + max_sweeps_between &&
         at_outputs_.norm > share_of_change * norm_at_change_ &&
         greatest_force(step, at_outputs_.residual) > margin_of_release * step.tolerance;
}

bool Newton::is_partly_constrained(const Step& step, std::size_t node) const noexcept {
  const springnet_network& network = step.network;
  if (pinned_[node] != 0 || !step.constrained()) return false;
  return network.cluster[node] != no_node || network.touching[node] != 0 || network.status[node] == SPRINGNET_SLIDING;
}

bool Newton::joined_without_contact(const Step& step, std::size_t node) const noexcept {
  const std::uint32_t cluster = step.network.cluster[node];
  return cluster != no_node && pinned_[node] == 0 && in_contact_[cluster] == 0;
}

void Newton::settle(Step& step, const springnet_state* before) {
  const springnet_network& network = step.network;
  const std::size_t n = network.node_count;
  springnet_state& outputs = *step.outputs;
  springnet_state& next = work_.state_beside(&outputs, before);
  const Three u = axes(outputs.velocity), next_u = axes(next.velocity);
  const Three p = axes(outputs.position), next_p = axes(next.position);
  const ThreeConst start = axes(step.free_position);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::copy_n(u[axis], n, next_u[axis]);
    std::copy_n(p[axis], n, next_p[axis]);
    if (!step.constrained()) continue;
    for (std::size_t k = 0; k < n; ++k) {
      if (!is_partly_constrained(step, k)) continue;
      // Undo the constraints: the host finds the constraint force from the unconstrained output.
      const std::size_t i = axis * n + k;
      if (!joined_without_contact(step, k)) next_u[axis][k] -= at_outputs_.free[i] - at_outputs_.residual[i];
      // Keep positions of rigidly connected nodes: from other positions the host would have to find the directions
      // again.
      if (network.cluster[k] == no_node) next_p[axis][k] = start[axis][k] + step.weight() * next_u[axis][k];
    }
  }
  const bool is_early = waits_with_releases(step, before);
  const bool has_contacts = network.surface_count > 0 || step.is_pushed();
  if (has_contacts) unconstrain_contacts(step, outputs, next, is_early);
  springnet_sweep call = work_.sweep_call(step, outputs, next);
  call.force = outputs.force;
  if (network.surface_count > 0 || network.body_contact_count > 0) call.inertia = inertia_.data();
  if (is_early) call.contacts = SPRINGNET_MAY_TOUCH;
  const bool was_constrained = step.constrained();
  work_.host.constrain(call);
  was_pinned_ = pinned_;
  const bool switched = find_pinned(step);
  for (const std::uint32_t k : contacts_) {
    // Separating nodes continue from where they were held: their free motion shows that they separate, not how far.
    // Chattering nodes stay too: where they touch depends on their free motion, a fixed point that may not converge.
    const bool separated = network.status[k] == SPRINGNET_FREE;
    const bool chatters = pinned_[k] != 0 && contact_changes_ >= patience;
    // Those that bodies push are where both have them.
    const bool is_lone = network.cluster[k] == no_node && !step.is_pushed(k);
    if (was_pinned_[k] == 0 || !is_lone || !(separated || chatters)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      next_u[axis][k] = u[axis][k];
      next_p[axis][k] = p[axis][k];
    }
  }
  Differing differing;
  differing.add(next.position, outputs.position, status_);
  differing.add(next.velocity, outputs.velocity, status_);
  // Bodies may have come near without moving a node: accelerations without constraints are not known yet.
  const bool changed = differing.any || (step.constrained() && !was_constrained);
  if (changed) {
    const bool may_follow =
        switched && was_constrained && network.rigid_count == 0 && before != nullptr && std::isfinite(at_outputs_.norm);
    if (may_follow) keep_acceleration(n);
    work_.evaluate(step, next);
    work_.free_accelerations(step);
    if (may_follow && needs_to_follow(step, next)) follow(step, next, before);
    step.outputs = &next;
  } else if (switched) {
    work_.free_accelerations(step);  // released nodes now have free ones
  }
  if (network.rigid_count > 0) linearise(step);
  if (switched || changed) ++contact_changes_;
  // Nodes that go on sliding take the friction of these outputs, which is part of the residual.
  if (switched || differing.beside_sliding || is_early) ++decisions_;
  switched_ = switched;
  if (!changed && !switched && !step.constrained()) return;
  // The derivatives may belong to another set of free nodes, or of pairs that press: of several on the same nodes the
  // flags do not show which.
  if ((switched || step.is_pushed()) && network.rigid_count == 0) linearised_ = false;
  assess(step, *step.outputs, at_outputs_);
  if (switched) rate_ = 1.0;
  if (switched || before == nullptr) {
    norm_at_change_ = at_outputs_.norm;
    last_switch_ = step.sweeps;
  }
}

void Newton::settle_prescribed(Step& step) {
  springnet_state& outputs = work_.outputs_in_place(step);
  springnet_state& next = work_.state_beside(&outputs);
  copy(sdk::view(outputs.position), next.position, step.network.node_count);
  copy(sdk::view(outputs.velocity), next.velocity, step.network.node_count);
  work_.host.constrain(work_.sweep_call(step, outputs, next));
  step.outputs = &next;
}

// Reads the host's decisions. Returns whether any node's changed.
bool Newton::find_pinned(const Step& step) {
  const springnet_network& network = step.network;
  bool switched = false;
  for (std::size_t k = 0; k < network.node_count; ++k) {
    const std::uint8_t status = network.status[k];
    switched = switched || status != status_[k];
    status_[k] = status;
    if (!pushed_.empty()) {
      switched = switched || network.pushed[k] != pushed_[k];
      pushed_[k] = network.pushed[k];
    }
    pinned_[k] = status == SPRINGNET_PRESCRIBED || status == SPRINGNET_STICKING ? 1 : 0;
    const std::uint32_t cluster = network.cluster[k];
    const bool touches = status == SPRINGNET_STICKING || status == SPRINGNET_SLIDING || step.is_pushed(k);
    if (cluster != no_node && touches) in_contact_[cluster] = 1;
  }
  return switched;
}

void Newton::unconstrain_contacts(const Step& step, const springnet_state& outputs, const springnet_state& free,
                                  bool keeps) {
  const springnet_network& network = step.network;
  const double w = step.weight();
  for (const std::uint32_t k : contacts_)
    Eigen::Map<NodeStep::Block>(inertia_.data() + 9 * std::size_t{k}) = network.mass[k] * NodeStep::Block::Identity();
  contacts_.clear();
  for (std::uint32_t k = 0; k < network.node_count; ++k) {
    const bool slides = is_pushed(step, k) || (is_partly_constrained(step, k) && !joined_without_contact(step, k));
    // Released nodes keep the system's outputs: the solution already includes their forces.
    const bool has_left = network.status[k] == SPRINGNET_FREE && network.cluster[k] == no_node && !step.is_pushed(k);
    if ((pinned_[k] != 0 || (slides && !has_left)) && network.fixed[k] == 0) contacts_.push_back(k);
  }
  if (contacts_.empty()) return;
  springnet_evaluation evaluation = step.evaluation_at_end(outputs);
  evaluation.acceleration = contact_acceleration_.view();
  evaluation.acceleration_by_velocity = by_velocity_.data();
  evaluation.acceleration_by_position = by_position_.data();
  work_.host.evaluate_nodes(evaluation, contacts_);
  for (const std::uint32_t k : contacts_) {
    springnet_node_batch batch = sdk::sized<springnet_node_batch>();
    batch.first = k;
    batch.count = 1;
    batch.acceleration = {&contact_acceleration_.x[k], &contact_acceleration_.y[k], &contact_acceleration_.z[k]};
    batch.acceleration_by_velocity = &by_velocity_[9 * std::size_t{k}];
    batch.acceleration_by_position = &by_position_[9 * std::size_t{k}];
    const NodeStep node(step, outputs, batch, 0, true);
    const bool rigid = network.cluster[k] != no_node;
    Eigen::Map<NodeStep::Block> inertia(inertia_.data() + 9 * std::size_t{k});
    Eigen::Vector3d change = -node.residual;
    const bool is_pinned = pinned_[k] != 0;
    if (!rigid && !is_pinned && step.is_pushed(k)) {
      // Friction of bodies takes its direction from how the node answers: one that moves far more easily across a taut
      // rope than along it would swing without end if it were as stiff in all directions.
      inertia = node.positive;
      change = node.positive.ldlt().solve(change).eval();
    } else {
      // Isotropic, with the inertia of the stiffest direction: connections under tension then turn little, and friction
      // finds its direction.
      const double stiffest = node.positive.operatorNorm();
      inertia = stiffest * NodeStep::Block::Identity();
      change /= stiffest;
    }
    if (!rigid && is_pinned) {
      // No farther than it moved in this step: the host holds a chattering node there.
      const double distance = (at(outputs.position, k) - at(step.start.position, k)).norm();
      const double speed = at(step.start.velocity, k).norm();
      const double max_change =
          std::max({distance, speed * step.time_constant, min_move_limit * network.length_scale}) / w;
      if (const double share = max_change / change.norm(); share < 1.0) {
        change *= share;
        inertia /= share;  // keeps the impulse that holds it
      }
    }
    if (!rigid && !is_pinned && keeps) {
      // The system has moved all nodes as their friction was: it is to be that of these outputs.
      change *= share_of_kept;
      inertia /= share_of_kept;
    }
    inertia *= network.mass[k];
    const Eigen::Vector3d u = node.velocity + change;
    Eigen::Vector3d p = at(outputs.position, k);
    if (!rigid && is_pinned) p += w * change;
    if (!rigid && !is_pinned) p = at(step.free_position, k) + w * u;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      axes(free.velocity)[axis][k] = u[static_cast<Eigen::Index>(axis)];
      axes(free.position)[axis][k] = p[static_cast<Eigen::Index>(axis)];
    }
  }
}

}  // namespace springnet::recurrent
