// Compares a scene in the recurrent network with a reference integrator: how far apart they are, and how that depends
// on the time step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/events.hpp>
#include <springnet/export.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

struct ValidationProgress {
  double time;      // s, the last record time that all runs have reached
  double duration;  // s
};

struct ValidationOptions {
  // s; in addition to the scene's own. Empty: half and a quarter of that.
  std::vector<double> time_steps;
  // Of the reference, and of the second run that certifies it.
  double relative_tolerance = 1e-8;
  double certifying_tolerance = 1e-10;
  std::string scene_name;  // for the report
  // Called after every record; false stops the validation with an Error(simulation).
  std::function<bool(const ValidationProgress&)> progress;
};

// Euclidean distances between the nodes of two runs at common times, m. max and rms are nan if the runs share no time
// but the start.
struct PositionError {
  double max = 0.0;  // over all nodes and record times
  double rms = 0.0;  // root mean square over all nodes and record times but the start
  NodeIndex node = 0;
  double time = 0.0;                // s, node and time of the maximum
  std::vector<double> max_by_time;  // over the nodes, for each record time
};

// How far the reference moves, the scale for errors: distances of nodes from their start, over all record times, m.
struct Displacement {
  double max = 0.0;
  NodeIndex node = 0;
  double time = 0.0;  // s, node and time of the maximum
  // The maximum without each body's rigid motion (translation and rotation by least squares): what remains of the
  // displacement of a body that falls, flies or turns as a whole.
  double deformation = 0.0;
};

struct ValidationRun {
  LawUse integrator;
  double time_step = 0.0;  // s
  bool of_scene = false;   // its time step and integrator are the scene's own
  PositionError error;     // up to the time the run reached
  std::uint64_t steps = 0;
  std::uint64_t sweeps = 0;
  EventCounts events;
  double reached = 0.0;                            // s, simulated
  double wall = 0.0;                               // s
  std::string outcome;                             // that of the worst time step ("settled", …) or "failed"
  std::string failure;                             // why it failed; empty otherwise
  ErrorKind failure_kind = ErrorKind::simulation;  // of that failure
  // log(e1 / e2) / log(t1 / t2) of rms errors, from the next larger time step to this one; nan where there is none.
  double order = std::numeric_limits<double>::quiet_NaN();

  [[nodiscard]] bool finished() const noexcept { return failure.empty(); }
};

struct Validation {
  std::string scene;
  std::string title;
  std::size_t nodes = 0;
  std::size_t springs = 0;
  double duration = 0.0;      // s
  std::vector<double> times;  // s, record times; the first is 0

  std::string reference;              // id of the reference integrator
  double relative_tolerance = 0.0;    // its own
  double certifying_tolerance = 0.0;  // of the second run
  PositionError certification;        // between the two: the reference's own uncertainty
  Displacement displacement;          // of the reference
  EventCounts reference_events;
  double reference_wall = 0.0;  // s, both runs

  std::vector<ValidationRun> runs;  // in descending order of time steps
  // The scene's time step with theta = 0.5 (second order). Empty if the integrator has no such parameter, or the scene
  // sets that value already.
  std::optional<ValidationRun> second_order;
  // Least-squares slope of log(rms error) over log(time step); nan with fewer than two points. Runs that failed, and
  // errors below ten times the reference's uncertainty, do not count.
  double observed_order = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::string> notes;  // what a reader should know about these numbers

  [[nodiscard]] double uncertainty() const noexcept { return certification.max; }
  // An error as a fraction of the reference's maximum displacement; nan if nothing moves.
  [[nodiscard]] SPRINGNET_API double share_of_displacement(double error) const noexcept;
  // Whether second_order finished and at least halves both errors of the scene's own run, or that run failed.
  [[nodiscard]] SPRINGNET_API bool second_order_is_better() const;
  [[nodiscard]] SPRINGNET_API const ValidationRun& run_of_scene() const;
  // Whether the scene's own run is within `tolerance` m of the true solution, the reference's uncertainty included.
  [[nodiscard]] SPRINGNET_API bool within(double tolerance) const;
};

// Runs the scene in the reference integrator `cvode` (twice, with different tolerances) and in the scene's integrator
// (`recurrent` if that is the reference) with each time step, and once with theta = 0.5. All runs advance together from
// record time to record time, so that no trajectory is stored. A failed run stays in the result with its outcome.
// Throws Error(input) for unusable time steps, Error(plugin), and Error(simulation) if the reference fails.
[[nodiscard]] SPRINGNET_API Validation validate(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                                                const ValidationOptions& options = {});

// Slope of log(errors) over log(time_steps) by least squares; nan with fewer than two points above `floor`.
[[nodiscard]] SPRINGNET_API double observed_order(const std::vector<double>& time_steps,
                                                  const std::vector<double>& errors, double floor = 0.0);

// Record times for the given time steps: multiples of an interval that all of them divide, if there is one at or near
// the wanted interval, and the duration. Throws Error(input) for a time step outside (0, duration].
struct RecordTimes {
  std::vector<double> times;                 // s, from 0
  std::vector<double> shortened_time_steps;  // those that do not divide the interval
};
[[nodiscard]] SPRINGNET_API RecordTimes common_record_times(double duration, double wanted_interval,
                                                            const std::vector<double>& time_steps);

// The text of validation.json; a self-contained page with table and plots; the table as text.
[[nodiscard]] SPRINGNET_API std::string to_json(const Validation& validation);
[[nodiscard]] SPRINGNET_API std::string to_html(const Validation& validation);
[[nodiscard]] SPRINGNET_API std::string to_table(const Validation& validation);

}  // namespace springnet
