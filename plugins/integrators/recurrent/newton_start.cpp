// Where a step of Newton's method starts.
#include "newton.hpp"

#include <algorithm>

#include "columns.hpp"

namespace springnet::recurrent {

void Newton::begin(Step& step) {
  const springnet_network& network = step.network;
  for (std::uint32_t k = 0; k < network.node_count; ++k) pinned_[k] = network.fixed[k] | network.held[k];
  extrapolation_.learn(step.from, sdk::view(step.start.velocity), network.node_count);
  const bool same_nodes = std::equal(status_.begin(), status_.end(), network.status);
  const bool turning_rows =
      network.rigid_count > 0 || std::count(status_.begin(), status_.end(), SPRINGNET_SLIDING) > 0;
  // Pairs of bodies, at the end of the last step and now: their rows are in the system.
  const auto presses = [](std::uint8_t pushed) { return pushed >= SPRINGNET_PUSHED; };
  const bool any_pairs =
      !pushed_.empty() && (std::any_of(pushed_.begin(), pushed_.end(), presses) ||
                           std::any_of(network.pushed, network.pushed + network.node_count, presses));
  const bool keeps = linearised_ && !any_pairs && !at_rejected_ && shift_ == 0.0 && kept_rate_ < fast_convergence &&
                     same_nodes && !turning_rows && age_ < max_age && system_.has(step.weight(), 0.0);
  ++age_;
  if (exact_steps_ > 0) --exact_steps_;
  if (approximate_steps_ > 0) --approximate_steps_;
  if (!keeps) linearised_ = false;
  rate_ = kept_rate_;
  std::copy_n(network.status, network.node_count, status_.begin());
  if (!pushed_.empty()) std::copy_n(network.pushed, network.node_count, pushed_.begin());
  guessed_ = step.outputs == nullptr && start_from_guess(step);
  try {
    start(step);
  } catch (const sdk::Failure& failure) {
    if (!guessed_ || !failure.recoverable()) throw;
    start_again(step);  // a law has no finite force at the guess
  }
}

// Puts nodes that move freely, or slide, where earlier steps lead. False: there is no guess, and outputs are those of
// the start.
bool Newton::start_from_guess(Step& step) {
  const springnet_network& network = step.network;
  springnet_state& outputs = work_.outputs_in_place(step);
  if (!extrapolation_.guess(step.until, outputs.velocity)) return false;
  const double w = step.weight();
  const Three u = axes(outputs.velocity), p = axes(outputs.position);
  const ThreeConst v = axes(sdk::view(step.start.velocity)), start = axes(step.free_position);
  for (std::uint32_t k = 0; k < network.node_count; ++k) {
    // What slides goes on sliding: settle() keeps it on its surface.
    const bool slides = network.status[k] == SPRINGNET_SLIDING && network.cluster[k] == no_node && !step.is_pushed(k);
    const bool is_free = pinned_[k] == 0 && (slides || !is_partly_constrained(step, k));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (is_free)
        p[axis][k] = start[axis][k] + w * u[axis][k];
      else
        u[axis][k] = v[axis][k];
    }
  }
  return true;
}

// Evaluates the outputs where the propagation starts.
void Newton::start(Step& step) {
  const springnet_network& network = step.network;
  work_.forget_constraint_force();
  // Prescribed nodes go where they will be; with surfaces or rigid connections settle() does that.
  if (!step.constrained()) settle_prescribed(step);
  springnet_state& outputs = work_.outputs_in_place(step);
  work_.evaluate(step, outputs);
  work_.record.begin(network, sdk::view(outputs.force), work_.acceleration().view());
  fresh_ = false;
  first_ = true;
  shift_ = 0.0;
  contact_changes_ = 0;
  slow_sweeps_ = 0;
  switched_ = false;
  std::fill(in_contact_.begin(), in_contact_.end(), std::uint8_t{0});
  for (std::uint32_t k = 0; k < network.node_count; ++k)
    if (network.cluster[k] != no_node && (network.touching[k] != 0 || step.is_pushed(k)))
      in_contact_[network.cluster[k]] = 1;
  if (step.constrained()) work_.free_accelerations(step);
  assess(step, outputs, at_outputs_);
  if (step.constrained()) settle(step, nullptr);
  norm_at_start_ = at_outputs_.norm;
}

// The careful way, after a guess that led astray: from the state at the start of the step.
void Newton::start_again(Step& step) {
  step.outputs = nullptr;
  step.has_begun_again = true;
  guessed_ = linearised_ = false;
  rate_ = kept_rate_ = 1.0;
  start(step);
}

void Newton::start_at_rest(const Step& step, const springnet_state& candidate) {
  const std::size_t n = step.network.node_count;
  const Three u = axes(step.outputs->velocity), next_u = axes(candidate.velocity);
  const Three p = axes(step.outputs->position), next_p = axes(candidate.position);
  const ThreeConst start = axes(step.free_position);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < n; ++k) {
      const bool free = pinned_[k] == 0 && !is_partly_constrained(step, k);
      next_p[axis][k] = p[axis][k];
      next_u[axis][k] = free ? (p[axis][k] - start[axis][k]) / step.weight() : u[axis][k];
    }
  }
  linearised_ = false;
  work_.evaluate(step, candidate);
  work_.free_accelerations(step);
  assess(step, candidate, at_candidate_);
}

}  // namespace springnet::recurrent
