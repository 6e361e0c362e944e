#include "recurrent.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "critical_time.hpp"

namespace springnet::recurrent {
namespace {

// An automatically chosen rule that has not settled after this many sweeps is replaced by a stronger one.
constexpr std::uint64_t automatic_patience = 200;
constexpr int max_halvings = 12;     // of a time step
constexpr int max_small_stages = 6;  // halvings of the time constant, to begin with
constexpr double min_raise = 1.05;   // of the time constant from stage to stage
constexpr double first_raise = 2.0;

}  // namespace

springnet_status Recurrent::advance(double until, springnet_step_report& report) {
  sweeps_ = stages_ = substeps_ = 0;
  return locates_ ? advance_by_events(until, report) : advance_once(until, report);
}

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
  const bool adapts = unsettled_ == Unsettled::adapt;
  const bool is_taken = ends(attempt.verdict) || (unsettled_ == Unsettled::accept && step.finite);
  if (is_taken && commits(step, attempt.verdict, adapts)) return SPRINGNET_OK;
  if (!adapts) throw sdk::Failure(explain(step, attempt, circumstances(step, attempt)), SPRINGNET_UNSETTLED);
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
    throw sdk::Failure("a time step must end after " + std::to_string(from) + " s, the time of the committed state");
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
  const bool from_start = step.outputs == nullptr;
  Anderson& acceleration = acceleration_for(update);
  const Attempt attempt = propagate_by(update, step, max_sweeps, acceleration);
  // Combined sweeps may cycle, or end far away, where plain ones settle.
  if (ends(attempt.verdict) || !accelerates_ || update == Update::newton || !from_start) return attempt;
  work_.host.begin_step(step.from, step.until);
  step.outputs = nullptr;
  return propagate_by(update, step, max_sweeps, no_acceleration_);
}

Attempt Recurrent::propagate_by(Update update, Step& step, std::uint64_t max_sweeps, Anderson& acceleration) {
  Attempt attempt;
  attempt.update = update;
  step.sweeps = 0;
  step.differences = {};
  step.keeps_order = step.waits = step.is_provisional = step.has_begun_again = false;
  step.relaxation = 1.0;
  step.start_node = no_node;
  step.finite = true;
  step.evaluated = false;
  step.residual_decides = false;
  step.residual = step.norm = step.rate = std::numeric_limits<double>::quiet_NaN();
  try {
    work_.know_start_acceleration(step);
    work_.set_free_motion(step);
    attempt.verdict = propagate(rule(update), work_, step, {max_sweeps, limits_.exact_sweeps}, acceleration, watch_);
    const bool stalled = attempt.verdict == Verdict::oscillating || attempt.verdict == Verdict::out_of_sweeps;
    if (stalled && settles_to_rounding(step)) attempt.verdict = Verdict::settled;
    const bool taken = ends(attempt.verdict) || unsettled_ == Unsettled::accept;
    if (step.finite && taken && !single_sweep()) work_.complete(step);
    // Rules that may diverge.
    const bool explicit_rule = update == Update::synchronous || update == Update::wavefront;
    if ((attempt.verdict == Verdict::settled || attempt.verdict == Verdict::out_of_time) && explicit_rule) {
      if (const std::uint32_t node = work_.spurious_contact(step); node != no_node) {
        attempt.verdict = Verdict::diverging;
        attempt.law_message = "the sweeps put node " + std::to_string(step.network.user_number[node]) +
                              " on a surface that its start velocity and force cannot take it to";
      }
    }
  } catch (const sdk::Failure& failure) {
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
      copy(sdk::view(stage_->position), step.outputs->position, step.network.node_count);
      copy(sdk::view(stage_->velocity), step.outputs->velocity, step.network.node_count);
    }
    step.time_constant = next;
    attempt = propagate_with(last.update, step, limits_.max_sweeps);
    if (settled(attempt.verdict)) {
      if (next == full) break;
      ++stages_;
      copy(sdk::view(step.outputs->position), stage_->position, step.network.node_count);
      copy(sdk::view(step.outputs->velocity), stage_->velocity, step.network.node_count);
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
  work_.host.count("stages", static_cast<double>(stages_));
  return attempt;
}

void Recurrent::take(const Step& step, Verdict verdict) {
  springnet_state& result = *step.outputs;
  result.force_is_current = step.evaluated ? 1 : 0;
  result.is_swept = step.compares ? 0 : 1;  // a single synchronous sweep, whose outputs nothing has changed
  work_.committed(step);
  work_.host.commit(step.until, result);
  has_committed_ = true;
  if (verdict == Verdict::out_of_time)
    work_.host.count("out_of_time_steps");
  else if (!settled(verdict))
    work_.host.count("unsettled_steps");
}

// False: the host refuses the outputs, as of bodies that overlap, and smaller steps may help.
bool Recurrent::commits(const Step& step, Verdict verdict, bool may_divide) {
  try {
    take(step, verdict);
    return true;
  } catch (const sdk::Failure& failure) {
    const bool is_unchanged = work_.host.committed().time == step.from;
    if (!failure.recoverable() || !may_divide || !is_unchanged) throw;
    return false;
  }
}

void Recurrent::subdivide(double until, int halvings, springnet_step_report& report) {
  Step step = make_step(until);
  const Attempt attempt = propagate_from_start(step);
  const springnet_step_report before = report;
  fill(report, step, attempt);
  if (ends(attempt.verdict) && commits(step, attempt.verdict, halvings < max_halvings)) {
    // The report has the worst of the smaller steps.
    if (substeps_ > 0 && before.residual > report.residual) {
      report.residual = before.residual;
      report.force_difference = before.force_difference;
      report.node = before.node;
    }
    report.substeps = ++substeps_;
    work_.host.count("substeps");
    return;
  }
  if (halvings == max_halvings) {
    Circumstances known = circumstances(step, attempt);
    known.divided = true;
    std::string reason = explain(step, attempt, known);
    for (const char* advice : {"; unsettled = ", ", or unsettled = "})  // which was followed
      if (const std::size_t at = reason.find(advice); at != std::string::npos) reason.erase(at);
    throw sdk::Failure("smaller and smaller steps did not help; the last one started at " + std::to_string(step.from) +
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
  result.starts_untested = result.exact_sweeps && has_committed_;
  result.accelerated = accelerates_;
  if (!attempt.law_message.empty() || !step.finite) {
    try {
      work_.evaluate(step, step.start);
    } catch (const sdk::Failure& failure) {
      result.fails_at_start = failure.recoverable();
    }
  }
  if (attempt.update == Update::synchronous || attempt.update == Update::wavefront) {
    try {
      if (!result.fails_at_start) result.over_critical = step.weight() / critical_weight(work_.host, step);
    } catch (const sdk::Failure&) {  // unknown, as for a law without derivatives
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

}  // namespace springnet::recurrent

SPRINGNET_PLUGIN("springnet.integrator.recurrent", "0.1.0", "springnet", "MIT", springnet::recurrent::Recurrent);
