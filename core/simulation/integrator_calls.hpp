// Supervises the calls of an integrator: its states in the engine's memory, the time up to which it may commit, and
// violations of the rules of plugin.h.
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
  // Throws Error(plugin) within a sweep or a search: callbacks of the integrator must not change the model.
  void require_no_callback() const;
  // Throws Error(plugin) while the integrator reports its limits.
  void require_advancing() const;
  // Whether the integrator is reporting its limits: it must not commit or fire events meanwhile.
  void set_reporting_limits(bool reports) noexcept { reports_limits_ = reports; }
  // Records the reason of a failed call as the message, and as misuse() if the integrator broke a rule.
  void refuse(const std::string& reason, bool misuse) noexcept;

  // The integrator is about to advance the network to `until`, s. Forgets earlier misuse.
  void begin_advance(double until);
  // The last violation of the rules since then; empty: none.
  [[nodiscard]] const std::string& misuse() const noexcept { return misuse_; }
  // Rounding of the end of the present advance, s.
  [[nodiscard]] double end_tolerance() const noexcept;
  [[nodiscard]] bool ends_at(double time) const noexcept { return time >= until_ - end_tolerance(); }
  // Throws Error if the integrator may not commit this. is_finite: all numbers of the state are known to be.
  void check_commit(double time, const State& state, bool is_finite) const;

 private:
  Model& model_;
  std::vector<std::unique_ptr<State>> states_;
  double from_ = 0.0, until_ = 0.0;  // s, the present advance
  std::string misuse_;
  bool reports_limits_ = false;
};

}  // namespace springnet
