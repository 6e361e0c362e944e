// What an integrator may do: states that it owns in the engine's memory, the time up to which it may commit, and what
// it did against the rules of plugin.h.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "simulation/model.hpp"

namespace springnet {

class IntegratorCalls {
 public:
  explicit IntegratorCalls(Model& model) : model_(model) {}

  // States for the integrator to work with; it knows no others.
  [[nodiscard]] springnet_state* create_state();
  void destroy_state(const springnet_state* state) noexcept;
  // Throws Error(plugin) if `state` is none of them.
  [[nodiscard]] State& created_state(const springnet_state* state);
  // Throws Error(plugin) within a sweep or a search: functions of the integrator may not call what changes the model.
  void require_no_callback() const;
  // Throws Error(plugin) while the integrator tells its limits.
  void require_advancing() const;
  // The integrator is about to tell its limits, or has: it may not commit or fire events meanwhile.
  void ask_limits(bool asks) noexcept { asks_limits_ = asks; }
  // A failed call: its reason becomes the message, and `misuse` if the fault was the integrator's.
  void refuse(const std::string& reason, bool misuse) noexcept;

  // The integrator is about to advance the network to `until`, s. Forgets earlier misuse.
  void begin_advance(double until);
  // What the integrator last did against the rules since then; empty: nothing.
  [[nodiscard]] const std::string& misuse() const noexcept { return misuse_; }
  // Rounding of the end of the present advance, s.
  [[nodiscard]] double end_tolerance() const noexcept;
  // Throws Error if the integrator may not commit this.
  void check_commit(double time, const State& state) const;

 private:
  Model& model_;
  std::vector<std::unique_ptr<State>> states_;
  double from_ = 0.0, until_ = 0.0;  // s, the present advance
  std::string misuse_;
  bool asks_limits_ = false;
};

}  // namespace springnet
