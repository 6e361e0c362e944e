#include "propagation.hpp"

#include <algorithm>
#include <cmath>

namespace springnet::recurrent {
namespace {

constexpr double residual_limit = 2.0;            // times the tolerance
constexpr std::uint64_t max_sweeps_between = 16;  // sweeps between evaluations of the residual
constexpr std::uint64_t max_stalled = 12;         // evaluations without a smaller residual
constexpr double noticeable = 0.9;                // of the smallest residual so far

// Decides when to evaluate the residual once the forces have settled.
class ResidualCheck {
 public:
  // After a sweep whose forces had settled.
  [[nodiscard]] bool is_due() noexcept { return ++sweeps_ >= next_; }
  [[nodiscard]] Verdict judge(double residual, double tolerance) noexcept {
    if (residual <= residual_limit * tolerance) return Verdict::settled;
    if (!std::isfinite(residual)) return Verdict::diverging;
    stalled_ = residual > noticeable * smallest_ ? stalled_ + 1 : 0;
    smallest_ = std::min(smallest_, residual);
    next_ = sweeps_ + between_;
    between_ = std::min(2 * between_, max_sweeps_between);
    return stalled_ >= max_stalled ? Verdict::oscillating : Verdict::go_on;
  }

 private:
  std::uint64_t sweeps_ = 0, next_ = 1, between_ = 1, stalled_ = 0;
  double smallest_ = std::numeric_limits<double>::infinity();
};

// A sweep of outputs that the acceleration put too far away for a law may fail: it then counts as not finite.
void sweep(Rule& rule, Step& step, const Anderson& acceleration) {
  try {
    rule.sweep(step);
    step.finite = step.finite && std::isfinite(step.differences.greatest);
  } catch (const sdk::Failure& failure) {
    if (!failure.recoverable() || step.outputs == nullptr || !acceleration.can_go_back()) throw;
    step.finite = false;
    ++step.sweeps;
  }
}

}  // namespace

bool within_tolerance(const Step& step) noexcept { return step.residual <= residual_limit * step.tolerance; }

Verdict propagate(Rule& rule, Workspace& workspace, Step& step, const Limits& limits, Anderson& acceleration,
                  Watch& watch) {
  rule.begin(step);
  watch.begin(step);
  acceleration.begin(step, rule.relaxes(), rule.changes_order());
  // A step ends with outputs of a sweep, as the host left them, where they are in contact or on rigid connections.
  const auto mixes_first = [&step] { return !step.constrained(); };
  Monitor monitor(step.tolerance, limits.max_sweeps);
  ResidualCheck check;
  while (limits.exact_sweeps == 0 || step.sweeps < limits.exact_sweeps) {
    const bool waited = step.waits;
    sweep(rule, step, acceleration);
    if (step.has_begun_again) {
      monitor.forget();
      check = {};
      step.has_begun_again = false;
    }
    if (!acceleration.record(step)) return Verdict::diverging;
    watch.after_sweep(step);
    // Contacts have to be decided.
    const bool is_over = watch.is_over() && !waited && !acceleration.went_back() && !step.is_provisional;
    if (limits.exact_sweeps > 0 && is_over && step.sweeps < limits.exact_sweeps) return Verdict::out_of_time;
    if (limits.exact_sweeps > 0) continue;
    if (acceleration.went_back()) {
      // Forget contacts and forces of the outputs that were left.
      if (step.constrained()) workspace.host.begin_step(step.from, step.until);
      workspace.record.begin();
    }
    if (watch.is_over()) step.waits = false;
    if (mixes_first() && !is_over) acceleration.mix(step);  // a step ends with outputs of a sweep at a deadline, too
    Verdict verdict = acceleration.went_back() ? monitor.skip() : monitor.judge(step.differences.greatest);
    if (step.residual_decides && step.residual <= step.tolerance) return Verdict::settled;
    if (waited && verdict != Verdict::go_on) {
      // Contacts have yet to be decided, whatever becomes of the step.
      step.waits = false;
      verdict = Verdict::go_on;
      check = {};
    } else if (verdict == Verdict::settled) {
      verdict = Verdict::go_on;
      if (check.is_due() || monitor.sweeps() >= limits.max_sweeps) {
        workspace.complete(step);
        verdict = check.judge(step.residual, step.tolerance);
        if (verdict == Verdict::go_on && monitor.sweeps() >= limits.max_sweeps) verdict = Verdict::out_of_sweeps;
      }
    }
    if (verdict != Verdict::go_on) return verdict;
    if (is_over) {
      watch.take_best(step);
      return Verdict::out_of_time;
    }
    if (waited && !step.waits) monitor.forget();
    if (acceleration.contacts_changed()) monitor.expect_jump();
    if (!mixes_first()) acceleration.mix(step);
  }
  return Verdict::go_on;
}

}  // namespace springnet::recurrent
