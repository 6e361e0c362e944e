// What the engine keeps for its integrator between the calls of the host table, and what it does not let pass.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "constraints/vectors.hpp"
#include "layers/message.hpp"
#include "plugin_host/call.hpp"
#include "simulation/engine.hpp"

namespace springnet {
namespace {

// An integrator that says something else in every step must not fill the memory.
constexpr std::size_t most_notes = 200, most_numbers = 500, longest_note = 2000;

}  // namespace

void Engine::note(const std::string& text) {
  const std::lock_guard guard(failure_lock_);
  const std::string shown = printable(text, longest_note);
  if (notes_.size() < most_notes && std::find(notes_.begin(), notes_.end(), shown) == notes_.end())
    notes_.push_back(shown);
}

void Engine::report(const std::string& name, double value) {
  const std::lock_guard guard(failure_lock_);
  const std::string shown = printable(name);
  if (statistics_.size() < most_numbers || statistics_.contains(shown)) statistics_[shown] = value;
}

springnet_state* Engine::create_state() {
  require_no_sweep();
  created_states_.push_back(std::make_unique<State>(layout_.node_count()));
  return &created_states_.back()->view;
}

void Engine::destroy_state(const springnet_state* state) noexcept {
  if (in_sweep_) return;
  std::erase_if(created_states_, [state](const auto& each) { return &each->view == state; });
}

State& Engine::created_state(const springnet_state* state) {
  const auto found = std::find_if(created_states_.begin(), created_states_.end(),
                                  [state](const auto& each) { return &each->view == state; });
  if (found == created_states_.end())
    throw Error(ErrorKind::plugin, "the state is none that state_create made, or was destroyed");
  const std::uint32_t current = (*found)->view.force_is_current;
  (*found)->restore_view();
  (*found)->view.force_is_current = current;
  return **found;
}

void Engine::require_no_sweep() const {
  if (in_sweep_) throw Error(ErrorKind::plugin, "it was called within a sweep or a search, by what those call");
}

void Engine::require_advancing() const {
  if (asks_limits_)
    throw Error(ErrorKind::plugin, "it was called by what tells limits, which must not change the network");
}

void Engine::refuse_call(const std::string& reason, bool misuse) noexcept {
  const std::lock_guard guard(failure_lock_);
  set_message(message_, reason);
  try {
    if (misuse) misuse_ = text_of(message_);  // as the integrator may repeat it
  } catch (const std::exception&) {
    misuse_.clear();  // out of memory: the message has it
  }
}

void Engine::begin_advance(double until) {
  advance_from_ = time_;
  advance_until_ = until;
  misuse_.clear();
  potential_energy_.reset();
}

double Engine::end_tolerance() const noexcept {
  return 1e-6 * std::max(0.0, advance_until_ - advance_from_) +
         4.0 * std::numeric_limits<double>::epsilon() * std::abs(advance_until_);
}

void Engine::check_commit(double time, const State& state) {
  if (!std::isfinite(time)) throw Error(ErrorKind::plugin, fmt::format("the time {} s is not finite", time));
  if (time < time_)
    throw Error(ErrorKind::plugin, fmt::format("{} s lies before {} s, committed already", time, time_));
  if (time > advance_until_ + end_tolerance())
    throw Error(ErrorKind::plugin, fmt::format("{} s lies after {} s, where the advance ends", time, advance_until_));
  const std::uint32_t node = state.first_not_finite();
  if (node == layout_.node_count()) return;
  if (!non_finite_.empty()) throw Error(ErrorKind::simulation, non_finite_);  // a law or a neuron was at fault
  const bool position = !vector_at(state.view.position, node).allFinite();
  throw Error(ErrorKind::plugin, fmt::format("the {} of node {} at {} s is not finite",
                                             position ? "position" : "velocity", layout_.ordering().user[node], time));
}

}  // namespace springnet
