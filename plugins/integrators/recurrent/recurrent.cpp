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
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <springnet/sdk/integrator.hpp>

#include "automatic.hpp"
#include "critical_time.hpp"
#include "crossings.hpp"
#include "explanation.hpp"
#include "limits.hpp"
#include "propagation.hpp"
#include "step_course.hpp"
#include "threshold.hpp"

namespace {

using namespace springnet::recurrent;
using springnet::sdk::choice;
using springnet::sdk::Failure;
using springnet::sdk::Host;
using springnet::sdk::integer;
using springnet::sdk::number;
using springnet::sdk::Options;
using springnet::sdk::Parameter;
using springnet::sdk::State;
using springnet::sdk::view;

// Those that sweeps follow; `automatic`, which chooses among them, is the last of the names.
constexpr int rules = static_cast<int>(Update::automatic);
// An automatically chosen rule that has not settled after this many sweeps is replaced by a stronger one.
constexpr std::uint64_t automatic_patience = 200;
// Sweeps that accelerated ones combine if the rule was chosen automatically.
constexpr std::size_t automatic_depth = 5;

enum class Unsettled : int { error, accept, adapt };
enum class Events : int { stepwise, located };

class Recurrent : public springnet::sdk::Integrator {
 public:
  static constexpr const char* id = "recurrent";
  static constexpr const char* summary =
      "the recurrent network: sweeps until the forces settle (backward Euler, or trapezoidal)";
  static constexpr const char* reference =
      "Nürnberger, Radetzky, Kruse: A Problem Specific Recurrent Neural Network for the Description and Simulation of "
      "Dynamic Spring Models, section 3.4";
  static constexpr Parameter parameters[] = {
      choice("update", {"synchronous", "wavefront", "block", "coloured", "newton", "automatic"},
             "all nodes at once; one after another from the node with the greatest force; the same, each to its own "
             "equilibrium; that by colours, in threads; Newton's method; what fits the time step")
          .preset(rules),
      number("force_tolerance", "N",
             "a step has settled when no force changes by more; 0: 1e-6 of the network's force scale")
          .preset(0)
          .at_least(0),
      integer("max_sweeps", "largest number of sweeps in a step").preset(1000).at_least(2).at_most(1e9),
      integer("sweeps",
              "exactly this number of sweeps per step; 0: until settled; 1 with update synchronous: symplectic Euler")
          .preset(0)
          .at_least(0)
          .at_most(1e9),
      choice("unsettled", {"error", "accept", "adapt"},
             "when a step does not settle: the run ends; it is taken as it is; a smaller time constant leads to it, or "
             "smaller steps replace it"),
      number("theta", "1", "weight of the new activities: 1 backward Euler (the paper), 0.5 trapezoidal, second order")
          .preset(1)
          .at_least(0.5)
          .at_most(1),
      integer("acceleration",
              "Anderson acceleration of synchronous, wavefront, block and coloured: combines this number of earlier "
              "sweeps; 0: none")
          .preset(0)
          .at_least(0)
          .at_most(Anderson::max_depth),
      choice("events", {"stepwise", "located"},
             "contacts and ruptures happen where a time step ends; or the step is divided where they, slip, rest and "
             "cuts happen, so that theta 0.5 stays of second order")};

  Recurrent(Host host, Options options)
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
      throw Failure("recurrent: acceleration combines sweeps until a step settles; set sweeps = 0 or acceleration = 0");
    if (update_ == Update::newton)
      throw Failure("recurrent: acceleration is for other rules than newton; set another update or acceleration = 0");
  }

  springnet_status advance(double until, springnet_step_report& report);
  void forget() noexcept;
  void limits(const springnet::sdk::LimitSink& sink) {
    attach();
    report_limits(
        work_, theta_, [this](Update update) -> Rule& { return rule(update); }, sink);
  }

 private:
  static constexpr int max_halvings = 12;     // of a time step
  static constexpr int max_small_stages = 6;  // halvings of the time constant, to begin with
  static constexpr double min_raise = 1.05;   // of the time constant from stage to stage
  static constexpr double first_raise = 2.0;
  static constexpr int max_events = 64;          // in a time step, apart from those at its end
  static constexpr int max_evaluations = 60;     // evaluations to locate an event
  static constexpr double min_part = 1e-6;       // smallest part of a time step between events
  static constexpr double shallow = 1e-7;        // times the length scale: shallower touches within a step do not count
  static constexpr double time_of_event = 1e-9;  // accuracy, relative to the divided step

  springnet_status advance_once(double until, springnet_step_report& report);
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
  // Propagates from step.outputs (null: the start) with the step's time constant.
  Attempt propagate_with(Update update, Step& step, std::uint64_t max_sweeps);
  // From the start of the step: with the rule of the scene, or the chosen one and then stronger ones.
  Attempt propagate_from_start(Step& step);
  Attempt propagate_again(Update update, Step& step);
  // Continuation: increasing time constants, each starting from the outputs of the one before.
  Attempt raise_time_constant(Step& step, const Attempt& last);
  void take(const Step& step, Verdict verdict);
  void subdivide(double until, int halvings, springnet_step_report& report);
  // Circumstances of a failed attempt, for its explanation.
  [[nodiscard]] Circumstances circumstances(const Step& step, const Attempt& attempt);
  void fill(springnet_step_report& report, const Step& step, const Attempt& attempt) const;
  [[nodiscard]] bool single_sweep(const Step& step) const {
    return limits_.exact_sweeps == 1 && update_ == Update::synchronous && step.network.internal_count == 0;
  }

  Update update_;
  Limits limits_;
  Unsettled unsettled_;
  double theta_;
  bool locates_;
  Crossings crossings_;
  double all_events_ = 0.0;
  Workspace work_;
  bool accelerates_;  // by the scene
  Anderson acceleration_, no_acceleration_{0};
  std::optional<std::uint64_t> acceleration_revision_;  // of the network at the last attach()
  Watch watch_;
  Threshold threshold_;
  Automatic automatic_;
  std::array<std::unique_ptr<Rule>, rules> rules_;
  std::array<std::optional<std::uint64_t>, rules> attached_;  // [rule] revision of the network at its last attach()
  std::optional<std::uint64_t> revision_;                     // at the workspace's last attach()
  State stage_;                                               // outputs of the last stage that settled
  std::uint64_t sweeps_ = 0, stages_ = 0, substeps_ = 0;      // in this call
  double all_stages_ = 0.0, all_substeps_ = 0.0, accepted_ = 0.0, late_ = 0.0;
};

springnet_status Recurrent::advance(double until, springnet_step_report& report) {
  sweeps_ = stages_ = substeps_ = 0;
  if (!locates_) return advance_once(until, report);
  const double whole = until - work_.host.committed().time;
  for (int parts = 0; work_.host.committed().time < until; ++parts) {
    const double from = work_.host.committed().time;
    double end = std::min(until, work_.host.next_discontinuity(from));
    if (until - end < min_part * whole) end = until;
    if (parts < max_events && advance_to_event(end, report)) continue;
    if (parts >= max_events)
      work_.host.note("events = \"located\": too many events in a time step; its rest was not divided");
    return advance_once(until, report);
  }
  return SPRINGNET_OK;
}

// Counters of statistics, and which notes were given, stay: they tell of the run.
void Recurrent::forget() noexcept {
  work_.forget();
  threshold_.forget();
  automatic_.forget();
  for (const std::unique_ptr<Rule>& rule : rules_)
    if (rule) rule->forget();
  attached_ = {};
  revision_.reset();
  acceleration_revision_.reset();
}

bool Recurrent::advance_to_event(double until, springnet_step_report& report) {
  const auto [from, start] = work_.host.committed();
  const double whole = until - from;
  work_.host.begin_step(from, until);
  crossings_.begin(work_.host, from, start);
  const std::uint64_t revision = work_.host.network().revision;  // whose events these are
  double time = until;
  std::vector<double> probes;  // s, times to search for touches within the step, latest first
  bool last = false;           // the interval cannot be narrowed further
  for (int evaluations = 0;; ++evaluations) {
    Step step = make_step(time);
    if (work_.host.network().revision != revision) return false;
    step.decides = false;
    const Attempt attempt = propagate_from_start(step);
    if (!settled(attempt.verdict)) return false;  // or out of time: too late to locate an event
    fill(report, step, attempt);
    const bool crossed = crossings_.evaluate(work_.host, time, *step.outputs);
    if (evaluations == 0)
      probes = times_of_impact(step);
    else if (crossed)
      probes.clear();
    if (!probes.empty()) {
      time = std::max(probes.back(), from + min_part * whole);
      probes.pop_back();
      continue;
    }
    if (!crossings_.any()) {
      if (time == until) {
        take(step, Verdict::settled);
        return true;
      }
      // Nodes that pass an obstacle between the probes: leave them to a step that decides contacts itself.
      return false;
    }
    // Within rounding, an event seen in a longer step may not occur in this one: take the step.
    if (!crossed && last) {
      take(step, Verdict::settled);
      return true;
    }
    const bool narrow = crossings_.high() - crossings_.low() <= time_of_event * whole || evaluations >= max_evaluations;
    if (crossed && (narrow || time <= from + min_part * whole)) {
      work_.host.fire_events(time, *step.outputs, crossings_.fired());
      step.evaluated = false;
      take(step, Verdict::settled);
      work_.host.report("located_events", ++all_events_);
      return true;
    }
    last = narrow;
    time = narrow ? crossings_.high() : std::max(crossings_.next_time(), from + min_part * whole);
  }
}

std::vector<double> Recurrent::times_of_impact(const Step& step) const {
  if (step.network.surface_count == 0) return {};
  const StepCourse course(step);
  const Host::Span whole{step.from, step.until};
  const auto write = [&](double time, const springnet_vectors& position, const springnet_vectors& velocity) {
    course.write(time, position, velocity);
  };
  const std::optional<double> first =
      work_.host.time_of_impact(whole, whole, shallow * step.network.length_scale, write);
  if (!first) return {};
  // A step that ends at that time differs from the dense output by the method's error: it may touch slightly later.
  std::vector<double> times;
  for (const double share : {1.0 / 4.0, 1.0 / 16.0}) times.push_back(*first + share * (step.until - *first));
  times.push_back(*first);
  return times;
}

springnet_status Recurrent::advance_once(double until, springnet_step_report& report) {
  Step step = make_step(until);
  Attempt attempt = propagate_from_start(step);
  // An automatically chosen rule may use continuation, too: the scene prescribes no path to the fixed point.
  const bool may_raise = unsettled_ == Unsettled::adapt || update_ == Update::automatic;
  if (!ends(attempt.verdict) && may_raise) {
    attempt = raise_time_constant(step, attempt);
    // Report, or accept, the step with its own time constant.
    if (!ends(attempt.verdict) && unsettled_ != Unsettled::adapt)
      attempt = propagate_again(update_ == Update::automatic ? Update::newton : attempt.update, step);
  }
  fill(report, step, attempt);
  if (ends(attempt.verdict) || (unsettled_ == Unsettled::accept && step.finite)) {
    take(step, attempt.verdict);
    return SPRINGNET_OK;
  }
  if (unsettled_ != Unsettled::adapt)
    throw Failure(explain(step, attempt, circumstances(step, attempt)), SPRINGNET_UNSETTLED);
  const double middle = step.from + 0.5 * (until - step.from);
  subdivide(middle, 1, report);
  subdivide(until, 1, report);
  return SPRINGNET_OK;
}

const springnet_network& Recurrent::attach() {
  const springnet_network& network = work_.host.network();
  if (revision_ != network.revision) {
    work_.attach(network);
    revision_ = network.revision;
  }
  return network;
}

Step Recurrent::make_step(double until) {
  const auto [from, start] = work_.host.committed();
  if (!(until > from)) {
    throw Failure("a time step must end after " + std::to_string(from) + " s, the time of the committed state");
  }
  work_.host.begin_step(from, until);
  const springnet_network& network = attach();
  const bool compares = !(limits_.exact_sweeps == 1 && update_ == Update::synchronous);
  Step step{from, until, until - from, theta_, 0.0, start, network, compares};
  // Rules that need no derivatives do without, unless a step does not settle.
  const bool has_derivatives = update_ != Update::synchronous && update_ != Update::wavefront;
  threshold_.begin(step, has_derivatives);
  return step;
}

bool Recurrent::settles_to_rounding(Step& step) {
  if (!step.finite || step.outputs == nullptr || !threshold_.is_rounding(step)) return false;
  work_.complete(step);
  return within_tolerance(step);
}

Rule& Recurrent::rule(Update update) {
  const auto i = static_cast<std::size_t>(update);
  if (!rules_[i]) rules_[i] = make_rule(update, work_);
  if (attached_[i] != revision_) {
    rules_[i]->attach(work_.host.network());
    attached_[i] = revision_;
  }
  return *rules_[i];
}

Anderson& Recurrent::acceleration_for(Update update) {
  const bool chosen = update_ == Update::automatic && update == Update::synchronous && automatic_.accelerates();
  if (update == Update::newton || !(accelerates_ || chosen)) return no_acceleration_;
  if (acceleration_revision_ != revision_) acceleration_.attach(work_.host.network());
  acceleration_revision_ = revision_;
  return acceleration_;
}

Attempt Recurrent::propagate_with(Update update, Step& step, std::uint64_t max_sweeps) {
  Attempt attempt;
  attempt.update = update;
  step.sweeps = 0;
  step.differences = {};
  step.keeps_order = step.waits = step.is_provisional = false;
  step.relaxation = 1.0;
  step.start_node = no_node;
  step.finite = true;
  step.evaluated = false;
  step.residual_decides = false;
  step.residual = step.norm = step.rate = std::numeric_limits<double>::quiet_NaN();
  try {
    work_.know_start_acceleration(step);
    work_.set_free_motion(step);
    attempt.verdict =
        propagate(rule(update), work_, step, {max_sweeps, limits_.exact_sweeps}, acceleration_for(update), watch_);
    const bool stalled = attempt.verdict == Verdict::oscillating || attempt.verdict == Verdict::out_of_sweeps;
    if (stalled && settles_to_rounding(step)) attempt.verdict = Verdict::settled;
    const bool taken = ends(attempt.verdict) || unsettled_ == Unsettled::accept;
    if (step.finite && taken && !single_sweep(step)) work_.complete(step);
    // Rules that may diverge.
    const bool explicit_rule = update == Update::synchronous || update == Update::wavefront;
    if ((attempt.verdict == Verdict::settled || attempt.verdict == Verdict::out_of_time) && explicit_rule) {
      if (const std::uint32_t node = work_.spurious_contact(step); node != no_node) {
        attempt.verdict = Verdict::diverging;
        attempt.law_message = "the sweeps put node " + std::to_string(step.network.user_number[node]) +
                              " on a surface that its start velocity and force cannot take it to";
      }
    }
  } catch (const Failure& failure) {
    if (!failure.recoverable()) throw;
    step.finite = false;  // a law or neuron has no finite result at the outputs
    attempt.law_message = failure.what();
  }
  if (!step.finite) {
    attempt.verdict = Verdict::diverging;
    if (attempt.law_message.empty()) step.differences.node = non_finite_node(step);
  }
  sweeps_ += step.sweeps;
  return attempt;
}

Attempt Recurrent::propagate_from_start(Step& step) {
  if (update_ != Update::automatic) return propagate_with(update_, step, limits_.max_sweeps);
  // With a given number of sweeps, the paper's rule.
  if (limits_.exact_sweeps > 0) {
    work_.host.note("update rule wavefront: the number of sweeps is given");
    return propagate_with(Update::wavefront, step, limits_.max_sweeps);
  }
  const Update chosen = automatic_.choose(work_, step);
  const std::uint64_t most = std::min(limits_.max_sweeps, automatic_patience);
  Attempt attempt = propagate_with(chosen, step, most);
  for (std::optional<Update> next = Automatic::after(chosen); next && !ends(attempt.verdict);
       next = Automatic::after(*next)) {
    attempt = propagate_again(*next, step);
  }
  if (settled(attempt.verdict) && attempt.update != chosen) automatic_.escalated(work_, chosen, attempt.update);
  return attempt;
}

Attempt Recurrent::propagate_again(Update update, Step& step) {
  work_.host.begin_step(step.from, step.until);  // discards the sweeps' decisions about contacts
  step.outputs = nullptr;
  return propagate_with(update, step, limits_.max_sweeps);
}

Attempt Recurrent::raise_time_constant(Step& step, const Attempt& last) {
  if (limits_.exact_sweeps > 0) return last;
  if (!stage_) stage_ = work_.host.make_state();
  const double full = step.until - step.from;
  double reached = 0.0, raise = first_raise;
  double next = full / raise;
  Attempt attempt = last;
  int small = 1;
  while (true) {
    work_.host.begin_step(step.from, step.until);
    step.outputs = nullptr;
    if (reached > 0.0) {
      step.outputs = &work_.state_beside(nullptr);
      copy(view(stage_->position), step.outputs->position, step.network.node_count);
      copy(view(stage_->velocity), step.outputs->velocity, step.network.node_count);
    }
    step.time_constant = next;
    attempt = propagate_with(last.update, step, limits_.max_sweeps);
    if (settled(attempt.verdict)) {
      if (next == full) break;
      ++stages_;
      copy(view(step.outputs->position), stage_->position, step.network.node_count);
      copy(view(step.outputs->velocity), stage_->velocity, step.network.node_count);
      reached = next;
    } else if (attempt.verdict == Verdict::out_of_time) {
      // Not the step's own solution, nor time for more than a sweep of it.
      step.time_constant = full;
      if (next < full) attempt = propagate_again(last.update, step);
      break;
    } else if (reached == 0.0) {
      if (++small > max_small_stages) break;
      next *= 0.5;
      continue;
    } else {
      raise = std::sqrt(raise);
      if (raise < min_raise) break;
    }
    next = reached * raise < full ? reached * raise : full;
  }
  step.time_constant = full;
  work_.host.report("stages", all_stages_ += static_cast<double>(stages_));
  return attempt;
}

void Recurrent::take(const Step& step, Verdict verdict) {
  springnet_state& result = *step.outputs;
  result.force_is_current = step.evaluated ? 1 : 0;
  work_.committed(step);
  work_.host.commit(step.until, result);
  if (verdict == Verdict::out_of_time)
    work_.host.report("out_of_time_steps", ++late_);
  else if (!settled(verdict))
    work_.host.report("unsettled_steps", ++accepted_);
}

void Recurrent::subdivide(double until, int halvings, springnet_step_report& report) {
  Step step = make_step(until);
  const Attempt attempt = propagate_from_start(step);
  const springnet_step_report before = report;
  fill(report, step, attempt);
  if (ends(attempt.verdict)) {
    // The report has the worst of the smaller steps.
    if (substeps_ > 0 && before.residual > report.residual) {
      report.residual = before.residual;
      report.force_difference = before.force_difference;
      report.node = before.node;
    }
    take(step, attempt.verdict);
    report.substeps = ++substeps_;
    work_.host.report("substeps", ++all_substeps_);
    return;
  }
  if (halvings == max_halvings) {
    Circumstances known = circumstances(step, attempt);
    known.divided = true;
    std::string reason = explain(step, attempt, known);
    for (const char* advice : {"; unsettled = ", ", or unsettled = "})  // which was followed
      if (const std::size_t at = reason.find(advice); at != std::string::npos) reason.erase(at);
    throw Failure("smaller and smaller steps did not help; the last one started at " + std::to_string(step.from) +
                      " s: " + reason,
                  SPRINGNET_UNSETTLED);
  }
  const double middle = step.from + 0.5 * (until - step.from);
  subdivide(middle, halvings + 1, report);
  subdivide(until, halvings + 1, report);
}

Circumstances Recurrent::circumstances(const Step& step, const Attempt& attempt) {
  Circumstances result;
  result.chosen_by_user = update_ != Update::automatic;
  result.exact_sweeps = limits_.exact_sweeps > 0;
  result.accelerated = accelerates_;
  if (!attempt.law_message.empty() || !step.finite) {
    try {
      work_.evaluate(step, step.start);
    } catch (const Failure& failure) {
      result.fails_at_start = failure.recoverable();
    }
  }
  if (attempt.update == Update::synchronous || attempt.update == Update::wavefront) {
    try {
      if (!result.fails_at_start) result.over_critical = step.weight() / critical_weight(work_.host, step);
    } catch (const Failure&) {  // unknown, as for a law without derivatives
    }
  }
  return result;
}

void Recurrent::fill(springnet_step_report& report, const Step& step, const Attempt& attempt) const {
  report.outcome = static_cast<std::int32_t>(settled(attempt.verdict) ? Verdict::settled : attempt.verdict);
  report.steps = 1;
  report.sweeps = sweeps_;
  report.force_difference = step.compares ? step.differences.greatest : std::numeric_limits<double>::quiet_NaN();
  report.residual = step.residual;
  report.node = step.differences.node == no_node ? 0 : step.differences.node;
  report.start_node = step.start_node;
  report.stages = stages_;
  report.position_error = watch_.position_error(step);
  report.substeps = substeps_;
}

}  // namespace

SPRINGNET_PLUGIN("springnet.integrator.recurrent", "0.1.0", "springnet", "MIT", Recurrent);
