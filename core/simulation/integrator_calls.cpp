#include "simulation/integrator_calls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "plugin_host/call.hpp"
#include "plugin_host/message.hpp"

namespace springnet {

springnet_state* IntegratorCalls::create_state() {
  require_no_callback();
  states_.push_back(std::make_unique<State>(model_.node_count(), model_.state.internal_count));
  return &states_.back()->view;
}

void IntegratorCalls::destroy_state(const springnet_state* state) noexcept {
  if (model_.in_callback) return;
  std::erase_if(states_, [state](const auto& each) { return &each->view == state; });
}

State& IntegratorCalls::created_state(const springnet_state* state) {
  const auto found =
      std::find_if(states_.begin(), states_.end(), [state](const auto& each) { return &each->view == state; });
  if (found == states_.end())
    throw Error(ErrorKind::plugin, "the state was not made by create_state, or was destroyed");
  const std::uint32_t current = (*found)->view.force_is_current;
  (*found)->restore_view();
  (*found)->view.force_is_current = current;
  return **found;
}

void IntegratorCalls::require_no_callback() const {
  if (model_.in_callback) throw Error(ErrorKind::plugin, "it was called from a callback of a sweep or a search");
}

void IntegratorCalls::require_advancing() const {
  if (reports_limits_)
    throw Error(ErrorKind::plugin, "it was called while limits are reported, which must not change the network");
}

void IntegratorCalls::refuse(const std::string& reason, bool misuse) noexcept {
  const std::lock_guard guard(model_.journal.failure_lock);
  set_message(model_.journal.message, reason);
  try {
    if (misuse) misuse_ = text_of(model_.journal.message);  // as truncated: the integrator may repeat it
  } catch (const std::exception&) {
    misuse_.clear();  // out of memory: the message has it
  }
}

void IntegratorCalls::begin_advance(double until) {
  from_ = model_.time;
  until_ = until;
  misuse_.clear();
}

double IntegratorCalls::end_tolerance() const noexcept {
  return 1e-6 * std::max(0.0, until_ - from_) + 4.0 * std::numeric_limits<double>::epsilon() * std::abs(until_);
}

void IntegratorCalls::check_commit(double time, const State& state, bool is_finite) const {
  if (!std::isfinite(time)) throw Error(ErrorKind::plugin, fmt::format("the time {} s is not finite", time));
  if (time < model_.time)
    throw Error(ErrorKind::plugin, fmt::format("{} s lies before {} s, committed already", time, model_.time));
  if (!state.internal_finite())
    throw Error(ErrorKind::plugin, fmt::format("the internal state of a law at {} s is not finite", time));
  if (time > until_ + end_tolerance())
    throw Error(ErrorKind::plugin, fmt::format("{} s lies after {} s, where the advance ends", time, until_));
  if (is_finite) return;
  const std::uint32_t node = state.first_not_finite();
  if (node == model_.node_count()) return;
  // A law or a neuron caused it.
  if (!model_.journal.non_finite.empty()) throw Error(ErrorKind::simulation, model_.journal.non_finite);
  const bool position = !vector_at(state.view.position, node).allFinite();
  throw Error(ErrorKind::plugin, fmt::format("the {} of node {} at {} s is not finite",
                                             position ? "position" : "velocity", model_.user_number(node), time));
}

}  // namespace springnet
