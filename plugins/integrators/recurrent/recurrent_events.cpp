// Steps of the recurrent network that are divided where contacts, slips, ruptures and cuts happen.
#include "recurrent.hpp"

#include <algorithm>
#include <optional>

#include "step_course.hpp"

namespace springnet::recurrent {
namespace {

constexpr int max_events = 64;          // in a time step, apart from those at its end
constexpr int max_evaluations = 60;     // to locate an event
constexpr double min_part = 1e-6;       // smallest part of a time step between events
constexpr double shallow = 1e-7;        // times the length scale: shallower touches within a step do not count
constexpr double time_of_event = 1e-9;  // accuracy, relative to the divided step

}  // namespace

springnet_status Recurrent::advance_by_events(double until, springnet_step_report& report) {
  const double whole = until - work_.host.committed().time;
  if (work_.host.network().body_contact_count > 0)
    work_.host.note(
        "events = \"located\": of bodies that touch each other contact is decided at the end of steps, of first order; "
        "cvode locates it");
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

bool Recurrent::advance_to_event(double until, springnet_step_report& report) {
  const auto [from, start] = work_.host.committed();
  const double whole = until - from;
  work_.host.begin_step(from, until);
  crossings_.begin(work_.host, from, start);
  // Loads have jumped: no crossing tells that a surface would have to pull by now, or friction to hold more than it
  // can. A step that decides contacts itself does.
  if (crossings_.is_due()) return false;
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
      work_.host.count("located_events");
      return true;
    }
    last = narrow;
    time = narrow ? crossings_.high() : std::max(crossings_.next_time(), from + min_part * whole);
  }
}

std::vector<double> Recurrent::times_of_impact(const Step& step) const {
  if (step.network.surface_count == 0) return {};
  const StepCourse course(step);
  const sdk::Host::Span whole{step.from, step.until};
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

}  // namespace springnet::recurrent
