#include "run/time_loop.hpp"

#include <algorithm>
#include <cmath>

#include "profile/stage.hpp"
#include "run/record_times.hpp"

namespace springnet {

bool Stepper::has_reached(double time) const {
  return simulation_->time() >= time - time_slack(simulation_->time_step(), time);
}

void Stepper::step(double end) {
  const double time_step = simulation_->time_step();
  const bool last = simulation_->time() + time_step >= end - time_slack(time_step, end);
  const auto springs = static_cast<double>(simulation_->live_spring_count());
  const double begin = clock_.now();
  const auto count_work = [&] {
    totals_.wall += clock_.now() - begin;
    totals_.spring_updates += static_cast<double>(simulation_->last_report().sweeps) * springs;
  };
  try {
    if (last) {
      simulation_->advance_to(end);
    } else {
      simulation_->step();
    }
  } catch (...) {
    count_work();
    throw;
  }
  count_work();
  count(simulation_->last_report());
}

void Stepper::count(const StepReport& report) {
  if (report.outcome != Outcome::settled) ++totals_.unsettled;
  if (report.substeps > 0) ++totals_.divided;
  totals_.substeps += report.substeps;
  totals_.stages += report.stages;
  totals_.worst = std::max(totals_.worst, report.outcome);
  if (std::isnan(report.residual)) return;
  totals_.last_residual = report.residual;
  totals_.largest_residual =
      std::isnan(totals_.largest_residual) ? report.residual : std::max(totals_.largest_residual, report.residual);
}

void Stepper::archive(Archive& archive) {
  archive.below(totals_.worst, 5, "an outcome");
  for (std::uint64_t* each : {&totals_.unsettled, &totals_.divided, &totals_.substeps, &totals_.stages})
    archive.number(*each);
  for (double* each : {&totals_.largest_residual, &totals_.last_residual, &totals_.spring_updates, &totals_.wall})
    archive.number(*each);
}

bool advance_to_end(Timeline& timeline, Pace* pace, const std::function<bool()>& go_on) {
  while (!timeline.has_ended()) {
    if (pace != nullptr) {
      const profile::Stage stage("wait for the clock");
      if (!pace->wait(timeline.time(), go_on)) return false;
    }
    timeline.advance();
    if (pace != nullptr) pace->count_frame(timeline.time());
    timeline.record_if_due();
    if (!go_on()) return timeline.has_ended();
  }
  return true;
}

}  // namespace springnet
