#include "validation/notes.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "text/counted.hpp"
#include "validation/scale.hpp"

namespace springnet {

namespace {

// If bodies move as a whole, their displacement says little about how exact their shape is.
void write_displacement_note(Validation& result) {
  constexpr double small = 0.1;
  const Displacement& moved = result.displacement;
  if (!(moved.deformation < small * moved.max) || moved.deformation <= 10.0 * result.uncertainty()) return;
  const ValidationRun& own = result.run_of_scene();
  result.notes.push_back(fmt::format(
      "Bodies move mostly as a whole: by up to {}, while they deform by {} at most. {}", length_text(moved.max),
      length_text(moved.deformation),
      own.finished() ? fmt::format("Of that the greatest error is {}.", share_text(own.error.max / moved.deformation))
                     : "Compare errors with that where shapes matter."));
}

}  // namespace

void write_notes(const RecordTimes& records, Validation& result) {
  for (const double time_step : records.shortened_time_steps) {
    result.notes.push_back(
        fmt::format("{:g} s does not divide the interval between records, so that the step before a record is "
                    "shorter; its error is not quite that of equal steps.",
                    time_step));
  }
  double least = std::numeric_limits<double>::infinity();
  for (const ValidationRun& run : result.runs) {
    if (!run.finished()) {
      result.notes.push_back(fmt::format("The run with {:g} s ended at {:g} s; its errors count up to there: {}",
                                         run.time_step, run.reached, run.failure));
      continue;
    }
    least = std::min(least, run.error.max);
    if (run.outcome != name_of(Outcome::settled)) {
      result.notes.push_back(fmt::format("The run with {:g} s accepted time steps that had not settled ({}).",
                                         run.time_step, run.outcome));
    }
    if (run.events.ruptured != result.reference_events.ruptured) {
      result.notes.push_back(
          fmt::format("With {:g} s {} ruptured, in the reference {}: from the first difference on these "
                      "are different networks.",
                      run.time_step, counted(run.events.ruptured, "spring"), result.reference_events.ruptured));
    }
  }
  if (least < 10.0 * result.uncertainty()) {
    result.notes.push_back(
        "An error is less than ten times the reference's uncertainty: tighten the reference's tolerance to see "
        "it exactly.");
  }
  write_displacement_note(result);
  const EventCounts& happened = result.reference_events;
  if (happened.touched + happened.released + happened.ruptured > 0) {
    result.notes.push_back(
        "Contact or rupture happens at the end of a time step in the network, at its exact time in the reference; the "
        "order of convergence holds between such events only.");
  }
}

}  // namespace springnet
