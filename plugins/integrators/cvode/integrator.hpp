// CVODE (SUNDIALS) for the network's equations of motion: variable order and step, local errors below given tolerances.
// The reference for other integrators.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <springnet/sdk/host.hpp>

#include "counters.hpp"
#include "dense_output.hpp"
#include "equations.hpp"
#include "linear_solver.hpp"
#include "sensitivities.hpp"
#include "settings.hpp"
#include "sundials.hpp"

namespace springnet::cvode {

class ReferenceIntegrator {
 public:
  // Throws sdk::Failure for inconsistent settings.
  ReferenceIntegrator(const sdk::Host& host, const Settings& settings);

  // Commits the state at `until` (s), and before it the states at events (contact, release, rupture) and at known
  // discontinuities (load switches, cuts). The internal steps do not depend on the position of `until` between those.
  // Throws sdk::Failure; the network is then in the state committed last.
  void advance(double until, springnet_step_report& report);
  // Drops CVODE's history, and all else that is kept but the counters: the next advance() starts as the first did.
  void forget();
  // The state at a time within the last advance(); throws sdk::Failure at others, and without the setting for it.
  void interpolate(double time, const springnet_vectors& position, const springnet_vectors& velocity) const;
  // From the committed state on, the motion is differentiated by these; none: no longer. advance() fails at events,
  // which derivatives do not go through. Throws sdk::Failure for rigid connections and laws with internal states.
  void begin_sensitivities(std::span<const springnet_sensitivity* const> columns);
  // Of the committed state.
  void sensitivity(std::uint32_t column, double* position, double* velocity) const {
    sensitivities_.read(column, position, velocity);
  }

 private:
  [[nodiscard]] LinearSolverKind linear_solver() const;
  void require_memory() const;
  void create(double time);
  // Restarts CVODE from the committed state; the next discontinuity is at `stop`.
  void restart(double time, const springnet_state& state, double stop);
  void bind(const springnet_network& network);
  [[nodiscard]] double first_step(double time, double stop);  // s
  void watch_events(double time);
  // Integrates to `until`, an event or a discontinuity, whichever is first, and commits that state.
  void step_towards(double until);
  // Integrates to a time, a root, or a touch between roots, whichever is first; y_ is the state there. Returns that
  // time; `event`: whether there is an event, marked in fired_.
  double solve_until(double target, bool& event);
  // The same with at most `max_steps` steps; false if they do not get that far.
  [[nodiscard]] bool steps_reach(double target, long max_steps, double& reached, bool& event);
  // Finds the first touch within the last step, up to `until`: roots show only touches visible at the ends of a step.
  void search_for_impact(double until);
  // Sets y_ to the state at a time within the last internal step.
  void return_to(double time);
  [[nodiscard]] bool mark_past_events() noexcept;
  void fire_events(double time);
  void require_differentiable(double time) const;
  [[noreturn]] static void refuse_event(const char* what, double time);
  void commit(double time);
  void check(int status) const;
  [[noreturn]] void fail(int flag, double time) const;
  [[nodiscard]] Counters counters() const;  // since the last restart
  [[nodiscard]] long internal_steps() const;
  void report_statistics();

  sdk::Host host_;
  Settings settings_;
  Equations equations_;
  Context context_;
  Sensitivities sensitivities_;
  Callbacks callbacks_;
  NonlinearSolver fixed_point_;
  Vector y_;
  Vector rate_, probe_, probe_rate_;  // of first_step
  Memory memory_;                     // destroyed before everything that it points to
  sdk::State state_;

  bool restart_ = true;
  bool projects_ = false;             // CVODE's projection is active: the motion is constrained
  std::uint64_t revision_ = 0;        // of the network when CVODE was started
  std::vector<double> event_values_;  // of the events that CVODE searches for
  std::vector<std::int32_t> fired_;   // 1: the event occurred
  std::optional<double> impact_;      // s: first touch in the last step
  double searched_until_ = 0.0;       // s: no touch up to here
  double restart_time_ = 0.0;         // s
  double last_event_time_;            // s
  std::uint64_t events_at_once_ = 0;
  long steps_before_ = 0;  // internal steps before advance()
  void forget_dense() {
    dense_.forget();
    dense_from_ = std::numeric_limits<double>::infinity();
  }
  DenseOutput dense_;                                            // if wanted
  double dense_from_ = std::numeric_limits<double>::infinity();  // s, where the last advance() began
  Counters total_;                                               // until the last restart
  std::uint64_t restarts_ = 0;
  std::map<std::string_view, double> reported_;  // what the host has of this integrator's counters
};

}  // namespace springnet::cvode
