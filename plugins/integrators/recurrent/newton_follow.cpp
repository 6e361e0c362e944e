// After the host has changed contacts: the other nodes follow those that it moved, and friction follows the slips.
#include <algorithm>
#include <cmath>

#include "columns.hpp"
#include "newton.hpp"

namespace springnet::recurrent {
namespace {

// (Measured on 300 bodies of 18 to 512 nodes that land on inclined planes, of which 31 do not settle in some step:
// others leave a few more, and always to follow takes a tenth longer.)
constexpr double accuracy_of_following = 0.05;
// So many changes of contacts in a step are made without.
constexpr std::uint64_t changes_without_following = 2;

}  // namespace

// Exchanges the outputs of `next` with those without following.
void Newton::swap_plain(springnet_state& next) {
  const std::size_t n = plain_.size() / 6;
  const Three u = axes(next.velocity), p = axes(next.position);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::swap_ranges(u[axis], u[axis] + n, plain_.begin() + static_cast<std::ptrdiff_t>(axis * n));
    std::swap_ranges(p[axis], p[axis] + n, plain_.begin() + static_cast<std::ptrdiff_t>((3 + axis) * n));
  }
}

void Newton::refresh_friction(const Step& step, const springnet_state& state, const springnet_state* before) {
  const springnet_network& network = step.network;
  if (network.surface_count == 0 || network.rigid_count > 0) return;
  if (std::count(network.status, network.status + network.node_count, SPRINGNET_SLIDING) == 0) return;
  const std::size_t n = network.node_count;
  springnet_state& next = work_.state_beside(&state, before);
  const Three u = axes(state.velocity), next_u = axes(next.velocity);
  const Three p = axes(state.position), next_p = axes(next.position);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::copy_n(u[axis], n, next_u[axis]);
    std::copy_n(p[axis], n, next_p[axis]);
  }
  unconstrain_contacts(step, state, next, true);
  springnet_sweep call = work_.sweep_call(step, state, next);
  call.force = state.force;
  call.inertia = inertia_.data();
  call.contacts = SPRINGNET_AS_BEFORE;
  work_.host.constrain(call);
}

void Newton::keep_acceleration(std::size_t nodes) {
  kept_acceleration_.resize(3 * nodes);
  const ThreeConst a = axes(work_.unconstrained());
  for (std::size_t axis = 0; axis < 3; ++axis)
    std::copy_n(a[axis], nodes, kept_acceleration_.begin() + static_cast<std::ptrdiff_t>(axis * nodes));
}

bool Newton::needs_to_follow(const Step& step, const springnet_state& next) {
  const double before = at_outputs_.norm;
  linearised_ = false;  // of other contacts
  assess(step, next, at_outputs_);
  return contact_changes_ >= changes_without_following || at_outputs_.norm > std::max(before, norm_at_start_);
}

void Newton::follow(Step& step, springnet_state& next, const springnet_state* before) {
  const double plain = at_outputs_.norm;
  if (!solve_to_follow(step, next)) return;
  const auto assess_next = [&] {
    work_.evaluate(step, next);
    work_.free_accelerations(step);
    refresh_friction(step, next, before);
    assess(step, next, at_outputs_);
  };
  assess_next();
  if (at_outputs_.norm < plain) return;
  swap_plain(next);
  assess_next();
}

bool Newton::solve_to_follow(const Step& step, springnet_state& next) {
  const std::size_t n = step.network.node_count;
  const springnet_state& outputs = *step.outputs;
  const double w = step.weight();
  const Three u = axes(outputs.velocity), next_u = axes(next.velocity);
  const Three p = axes(outputs.position), next_p = axes(next.position);
  const ThreeConst v = axes(step.free_velocity), start = axes(step.free_position);
  // The residual without constraints, and what the moves of the others change of it.
  std::vector<double>&dp = work_values_, &du = uncorrected_;  // neither is in use between sweeps
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < n; ++k) {
      dp[axis * n + k] = w * (next_p[axis][k] - p[axis][k]);
      du[axis * n + k] = w * (next_u[axis][k] - u[axis][k]);
    }
  }
  try {
    system_.prepare(step.evaluation_at_end(outputs), w, 0.0, false);
    work_.host.linearise(step.evaluation_at_end(outputs));
    work_.host.jacobian_times(dp.data(), du.data(), right_side_.data());
  } catch (const sdk::Failure& failure) {
    if (!failure.recoverable()) throw;
    return false;
  }
  linearised_ = true;
  fresh_ = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = axis * n + k;
      right_side_[i] =
          pinned_[k] != 0 ? 0.0 : right_side_[i] - (next_u[axis][k] - v[axis][k] - w * kept_acceleration_[i]);
    }
  }
  system_.project(right_side_);
  if (!system_.solve(right_side_, accuracy_of_following, correction_) || system_.truncated()) return false;
  plain_.resize(6 * n);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < n; ++k) {
      plain_[axis * n + k] = next_u[axis][k];
      plain_[3 * n + axis * n + k] = next_p[axis][k];
      if (pinned_[k] != 0) continue;
      next_u[axis][k] += correction_[axis * n + k];
      next_p[axis][k] = is_partly_constrained(step, k) ? next_p[axis][k] + w * correction_[axis * n + k]
                                                       : start[axis][k] + w * next_u[axis][k];
    }
  }
  return true;
}

}  // namespace springnet::recurrent
