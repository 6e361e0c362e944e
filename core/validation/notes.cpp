#include "validation/notes.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "text/counted.hpp"
#include "validation/scale.hpp"

namespace springnet {

namespace {

// If bodies move as a whole, errors relative to their displacement say little about their shape.
void write_displacement_note(Validation& result) {
  constexpr double small = 0.1;
  const Displacement& moved = result.displacement;
  if (!(moved.deformation < small * moved.max) || moved.deformation <= 10.0 * result.uncertainty()) return;
  const ValidationRun& own = result.run_of_scene();
  result.notes.push_back(fmt::format("Bodies move mostly as a whole: by up to {}, but deform by at most {}. {}",
                                     length_text(moved.max), length_text(moved.deformation),
                                     own.finished() ? fmt::format("The greatest error is {} of the deformation.",
                                                                  share_text(own.error.max / moved.deformation))
                                                    : "Compare errors with the deformation if shapes matter."));
}

}  // namespace

void write_notes(const RecordTimes& records, Validation& result) {
  for (const double time_step : records.shortened_time_steps) {
    result.notes.push_back(
        fmt::format("A time step of {:g} s does not divide the interval between records: the step before each record "
                    "is shorter, so the error is not quite that of equal steps.",
                    time_step));
  }
  double smallest_error = std::numeric_limits<double>::infinity();
  for (const ValidationRun& run : result.runs) {
    if (!run.finished()) {
      result.notes.push_back(fmt::format("The run with {:g} s ended at {:g} s, and its errors are those up to then: {}",
                                         run.time_step, run.reached, run.failure));
      continue;
    }
    smallest_error = std::min(smallest_error, run.error.max);
    if (run.outcome != name_of(Outcome::settled)) {
      result.notes.push_back(fmt::format("The run with {:g} s accepted time steps that had not settled ({}).",
                                         run.time_step, run.outcome));
    }
    if (run.events.ruptured != result.reference_events.ruptured) {
      result.notes.push_back(
          fmt::format("With {:g} s, {} ruptured, but {} in the reference: from the first difference on these are "
                      "different networks.",
                      run.time_step, counted(run.events.ruptured, "spring"), result.reference_events.ruptured));
    }
  }
  if (smallest_error < 10.0 * result.uncertainty()) {
    result.notes.push_back(
        "An error is less than ten times the uncertainty of the reference: lower the tolerance of the reference to "
        "resolve it.");
  }
  write_displacement_note(result);
  const EventCounts& happened = result.reference_events;
  if (happened.touched + happened.released + happened.ruptured > 0) {
    result.notes.push_back(
        "The network makes and breaks contacts, and ruptures springs, at the end of a time step, the reference at the "
        "exact time; the order of convergence holds only between such events.");
  }
}

}  // namespace springnet
