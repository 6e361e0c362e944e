// The recurrent network as integrator. In a time step of t_c the activities p, v are frozen; outputs P, U start from
// them and are propagated sweep by sweep,
//
//   a  = A(F(P, U, t + t_c), P, U)        springs, loads and neurons, by the host
//   U' = v + t_c a
//   P' = p + t_c U'
//
// until the forces stop changing; then the outputs become the activities. The fixed point is the backward Euler step,
// a single synchronous sweep is the symplectic Euler step. The paper: Nürnberger, Radetzky, Kruse, "A Problem Specific
// Recurrent Neural Network for the Description and Simulation of Dynamic Spring Models", section 3.4. Other update
// rules reach the same fixed point (rule.hpp), theta weighs old and new activities (step.hpp).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <springnet/sdk/integrator.hpp>

#include "automatic.hpp"
#include "crossings.hpp"
#include "explanation.hpp"
#include "limits.hpp"
#include "propagation.hpp"
#include "threshold.hpp"

namespace springnet::recurrent {

// Those that sweeps follow; `automatic`, which chooses among them, is the last of the names.
inline constexpr int rules = static_cast<int>(Update::automatic);
// Sweeps that accelerated ones combine if the rule was chosen automatically.
inline constexpr std::size_t automatic_depth = 5;

enum class Unsettled : int { error, accept, adapt };
enum class Events : int { stepwise, located };

class Recurrent : public sdk::Integrator {
 public:
  static constexpr const char* id = "recurrent";
  static constexpr const char* summary =
      "the recurrent network: sweeps until the forces settle (backward Euler, or trapezoidal)";
  static constexpr const char* reference =
      "Nürnberger, Radetzky, Kruse: A Problem Specific Recurrent Neural Network for the Description and Simulation of "
      "Dynamic Spring Models, section 3.4";
  static constexpr bool integrates_states = true;
  static constexpr bool keeps_bodies_apart = true, keeps_rigid_bodies_apart = true;
  static constexpr sdk::Parameter parameters[] = {
      sdk::choice(
          "update", {"synchronous", "wavefront", "block", "coloured", "newton", "automatic"},
          "all nodes at once; one after another from the node with the greatest force; the same, each to its own "
          "equilibrium; that by colours, in threads; Newton's method; what fits the time step")
          .preset(rules),
      sdk::number("force_tolerance", "N",
                  "a step has settled when no force changes by more; 0: 1e-6 of the network's force scale")
          .preset(0)
          .at_least(0),
      sdk::integer("max_sweeps", "largest number of sweeps in a step").preset(1000).at_least(2).at_most(1e9),
      sdk::integer(
          "sweeps",
          "exactly this number of sweeps per step; 0: until settled; 1 with update synchronous: symplectic Euler")
          .preset(0)
          .at_least(0)
          .at_most(1e9),
      sdk::choice(
          "unsettled", {"error", "accept", "adapt"},
          "when a step does not settle: the run ends; it is taken as it is; a smaller time constant leads to it, or "
          "smaller steps replace it"),
      sdk::number("theta", "1",
                  "weight of the new activities: 1 backward Euler (the paper), 0.5 trapezoidal, second order")
          .preset(1)
          .at_least(0.5)
          .at_most(1),
      sdk::integer(
          "acceleration",
          "Anderson acceleration of synchronous, wavefront, block and coloured: combines this number of earlier "
          "sweeps; 0: none")
          .preset(0)
          .at_least(0)
          .at_most(Anderson::max_depth),
      sdk::choice(
          "events", {"stepwise", "located"},
          "contacts and ruptures happen where a time step ends; or the step is divided where they, slip, rest and "
          "cuts happen, so that theta 0.5 stays of second order")};

  Recurrent(sdk::Host host, sdk::Options options)
      : update_(options.choice<Update>("update")),
        limits_{options.integer<std::uint64_t>("max_sweeps"), options.integer<std::uint64_t>("sweeps")},
        unsettled_(options.choice<Unsettled>("unsettled")),
        theta_(options["theta"]),
        locates_(options.choice<Events>("events") == Events::located),
        work_(host),
        accelerates_(options.integer<int>("acceleration") > 0),
        acceleration_(accelerates_                   ? options.integer<std::size_t>("acceleration")
                      : update_ == Update::automatic ? automatic_depth
                                                     : 0),
        watch_(host),
        threshold_(host, options["force_tolerance"], limits_.exact_sweeps > 0) {
    if (!accelerates_) return;
    if (limits_.exact_sweeps > 0)
      throw sdk::Failure(
          "recurrent: acceleration combines sweeps until a step settles; set sweeps = 0 or acceleration = 0");
    if (update_ == Update::newton)
      throw sdk::Failure(
          "recurrent: acceleration is for other rules than newton; set another update or acceleration = 0");
  }

  springnet_status advance(double until, springnet_step_report& report);
  void forget() noexcept;
  void limits(const sdk::LimitSink& sink) {
    attach();
    report_limits(
        work_, theta_, [this](Update update) -> Rule& { return rule(update); }, sink);
  }

 private:
  springnet_status advance_once(double until, springnet_step_report& report);
  springnet_status advance_by_events(double until, springnet_step_report& report);
  // Advances to the next event, or `until`. False: a step did not settle, and nothing was committed.
  [[nodiscard]] bool advance_to_event(double until, springnet_step_report& report);
  // Times (s, latest first) at which to search for touches within the step that are not visible at its ends.
  [[nodiscard]] std::vector<double> times_of_impact(const Step& step) const;
  // Attaches the workspace to the present network, which is returned.
  const springnet_network& attach();
  [[nodiscard]] Step make_step(double until);
  // Whether a step that stalled has settled but for the rounding of its forces.
  [[nodiscard]] bool settles_to_rounding(Step& step);
  [[nodiscard]] Rule& rule(Update update);
  // What combines the sweeps of a rule: for automatic only where it settles sooner, unless the scene asks for it.
  [[nodiscard]] Anderson& acceleration_for(Update update);
  // Propagates from step.outputs (null: the start) with the step's time constant; from the start again without
  // acceleration if the step did not end with it.
  Attempt propagate_with(Update update, Step& step, std::uint64_t max_sweeps);
  Attempt propagate_by(Update update, Step& step, std::uint64_t max_sweeps, Anderson& acceleration);
  // From the start of the step: with the rule of the scene, or the chosen one and then stronger ones.
  Attempt propagate_from_start(Step& step);
  Attempt propagate_again(Update update, Step& step);
  // Continuation: increasing time constants, each starting from the outputs of the one before.
  Attempt raise_time_constant(Step& step, const Attempt& last);
  void take(const Step& step, Verdict verdict);
  bool commits(const Step& step, Verdict verdict, bool may_divide);
  void subdivide(double until, int halvings, springnet_step_report& report);
  // Circumstances of a failed attempt, for its explanation.
  [[nodiscard]] Circumstances circumstances(const Step& step, const Attempt& attempt);
  void fill(springnet_step_report& report, const Step& step, const Attempt& attempt) const;
  [[nodiscard]] bool single_sweep() const { return limits_.exact_sweeps == 1 && update_ == Update::synchronous; }

  Update update_;
  Limits limits_;
  Unsettled unsettled_;
  double theta_;
  bool locates_;
  Crossings crossings_;
  Workspace work_;
  bool accelerates_;  // by the scene
  Anderson acceleration_, no_acceleration_{0};
  std::optional<std::uint64_t> acceleration_revision_;  // of the network at the last attach()
  Watch watch_;
  Threshold threshold_;
  Automatic automatic_;
  std::array<std::unique_ptr<Rule>, rules> rules_;
  std::array<std::optional<std::uint64_t>, rules> attached_;  // [rule] revision of the network at its last attach()
  bool has_committed_ = false;                                // a step
  std::optional<std::uint64_t> revision_;                     // at the workspace's last attach()
  sdk::State stage_;                                          // outputs of the last stage that settled
  std::uint64_t sweeps_ = 0, stages_ = 0, substeps_ = 0;      // in this call
};

}  // namespace springnet::recurrent
