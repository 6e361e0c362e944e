#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/validation.hpp>

#include "text/counted.hpp"
#include "validation/displacement.hpp"
#include "validation/error_norm.hpp"
#include "validation/scale.hpp"

namespace springnet {

namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* reference_id = "cvode";
constexpr const char* subject_id = "recurrent";

// One run among those that go on side by side.
class Lane {
 public:
  Lane(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const LawUse& integrator, double time_step)
      : simulation_(scene.network, plugins, options_for(scene, integrator, time_step)) {}

  // Throws Error(simulation) if the run fails on the way.
  void advance_to(double time) {
    if (time <= simulation_.time()) return;
    const auto begin = Clock::now();
    const auto stop = [&] { wall_ += std::chrono::duration<double>(Clock::now() - begin).count(); };
    try {
      // One at a time, because the report of several steps has the outcome of the last.
      while (time - simulation_.time() > (1.0 + 1e-6) * simulation_.time_step()) note(simulation_.step());
      note(simulation_.advance_to(time));
    } catch (...) {
      stop();
      throw;
    }
    stop();
  }

  [[nodiscard]] const Simulation& simulation() const { return simulation_; }
  [[nodiscard]] double wall() const { return wall_; }
  [[nodiscard]] Outcome worst() const { return worst_; }
  // Time steps that did not settle, and were made in smaller ones.
  [[nodiscard]] std::uint64_t divided() const { return divided_; }

 private:
  void note(const StepReport& report) {
    worst_ = std::max(worst_, report.outcome);
    divided_ += report.substeps > 0 ? 1 : 0;
  }
  static SimulationOptions options_for(const Scene& scene, const LawUse& integrator, double time_step) {
    SimulationOptions options = scene.options;
    options.integrator = integrator;
    options.time_step = time_step;
    return options;
  }
  Simulation simulation_;
  double wall_ = 0.0;  // s
  Outcome worst_ = Outcome::settled;
  std::uint64_t divided_ = 0;
};

// A run of the integrator that is examined.
struct Subject {
  Subject(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const LawUse& integrator,
          double time_step)
      : lane(scene, plugins, integrator, time_step) {
    run.integrator = integrator;
    run.time_step = time_step;
  }
  Lane lane;
  ErrorNorm norm;
  ValidationRun run;
};

constexpr const char* theta = "theta";
constexpr double second_order_theta = 0.5;

// The integrator with theta = 0.5; empty if it has no such parameter or that value already.
std::optional<LawUse> with_second_order(const LawUse& integrator, const PluginHost& plugins) {
  const springnet_component& description = *plugins.require(ComponentKind::integrator, integrator.id)->description;
  const std::ptrdiff_t index = parameter_index(description, theta);
  if (index < 0) return std::nullopt;
  const std::vector<double> values = complete_parameters(description, integrator.parameters, integrator.id);
  if (values[static_cast<std::size_t>(index)] == second_order_theta) return std::nullopt;
  if (!check_value(*description.parameters[index], second_order_theta).empty()) return std::nullopt;
  LawUse result = integrator;
  result.parameters[theta] = second_order_theta;
  return result;
}

LawUse reference_use(const Scene& scene, double tolerance, double scale) {
  LawUse use{reference_id, {}};
  if (scene.options.integrator.id == reference_id) use = scene.options.integrator;
  use.parameters["relative_tolerance"] = tolerance;
  // Absolute tolerances are derived from the relative one unless the scene sets them.
  for (const char* absolute : {"position_tolerance", "velocity_tolerance"}) {
    const auto given = use.parameters.find(absolute);
    if (given != use.parameters.end()) given->second *= scale;
  }
  return use;
}

std::vector<double> time_steps_of(const Scene& scene, const std::vector<double>& asked) {
  const double own = scene.options.time_step;
  std::vector<double> result = asked.empty() ? std::vector<double>{own / 2.0, own / 4.0} : asked;
  result.push_back(own);
  std::sort(result.begin(), result.end(), std::greater<>());
  // The scene's own may have been named again, in other digits.
  const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-12 * a; };
  result.erase(std::unique(result.begin(), result.end(), same), result.end());
  return result;
}

void finish(Subject& subject) {
  ValidationRun& run = subject.run;
  const Simulation& simulation = subject.lane.simulation();
  run.error = subject.norm.result();
  run.steps = simulation.steps();
  run.sweeps = simulation.sweeps();
  run.wall = subject.lane.wall();
  if (run.finished()) run.outcome = name_of(subject.lane.worst());
  run.events = count_events(simulation);
}

// One record time further; a run that fails is left behind with its reason.
void advance(Subject& subject, double time, const Simulation& reference) {
  if (!subject.run.finished()) return;
  const Simulation& simulation = subject.lane.simulation();
  try {
    subject.lane.advance_to(time);
    subject.norm.add(time, simulation.positions(), simulation.columns(), reference.positions(), reference.columns());
    subject.run.reached = time;
  } catch (const Error& error) {
    const Outcome outcome = simulation.last_report().outcome;
    subject.run.failure = error.what();
    subject.run.failure_kind = error.kind();
    subject.run.outcome = outcome == Outcome::settled ? "failed" : std::string(name_of(outcome));
    subject.run.reached = simulation.time();
  }
}

void advance_reference(Lane& lane, double time, double tolerance) {
  try {
    lane.advance_to(time);
  } catch (const Error& error) {
    throw Error(error.kind(),
                fmt::format("the reference ({}, relative tolerance {:g}) failed after {:g} s, so there is "
                            "nothing to compare with: {}",
                            reference_id, tolerance, lane.simulation().time(), error.what()));
  }
}

void find_orders(Validation& result) {
  const double floor = 10.0 * result.uncertainty();
  std::vector<double> time_steps, errors;
  for (const ValidationRun& run : result.runs) {
    if (!run.finished()) continue;
    time_steps.push_back(run.time_step);
    errors.push_back(run.error.rms);
  }
  result.observed_order = observed_order(time_steps, errors, floor);
  for (std::size_t k = 1; k < result.runs.size(); ++k) {
    const ValidationRun& coarse = result.runs[k - 1];
    ValidationRun& fine = result.runs[k];
    if (!coarse.finished() || !fine.finished()) continue;
    fine.order = observed_order({coarse.time_step, fine.time_step}, {coarse.error.rms, fine.error.rms}, floor);
  }
}

// Where bodies move as a whole, their displacement says little about how exact their shape is.
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

}  // namespace

const ValidationRun& Validation::run_of_scene() const {
  return *std::find_if(runs.begin(), runs.end(), [](const ValidationRun& run) { return run.of_scene; });
}

double Validation::share_of_displacement(double error) const noexcept {
  return displacement.max > 0.0 ? error / displacement.max : std::numeric_limits<double>::quiet_NaN();
}

bool Validation::second_order_is_better() const {
  if (!second_order || !second_order->finished()) return false;
  const ValidationRun& own = run_of_scene();
  constexpr double noteworthy = 0.5;
  // Below the uncertainty of the reference nothing can be told apart.
  return !own.finished() ||
         (own.error.max > 2.0 * uncertainty() && second_order->error.max <= noteworthy * own.error.max &&
          second_order->error.rms <= noteworthy * own.error.rms);
}

bool Validation::within(double tolerance) const {
  const ValidationRun& run = run_of_scene();
  return run.finished() && run.error.max + uncertainty() <= tolerance;
}

Validation validate(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                    const ValidationOptions& options) {
  check_starts(scene);
  if (!(options.relative_tolerance > options.certifying_tolerance) || !(options.certifying_tolerance > 0.0)) {
    throw Error(ErrorKind::input,
                fmt::format("the run that certifies the reference needs a relative tolerance above 0 and below the "
                            "reference's ({:g}); {:g} was given",
                            options.relative_tolerance, options.certifying_tolerance));
  }
  const std::vector<double> time_steps = time_steps_of(scene, options.time_steps);
  const RecordTimes records = common_record_times(scene.duration, scene.output.interval, time_steps);
  const double interval = records.times[1];

  Lane reference(scene, plugins, reference_use(scene, options.relative_tolerance, 1.0), interval);
  Lane certifier(
      scene, plugins,
      reference_use(scene, options.certifying_tolerance, options.certifying_tolerance / options.relative_tolerance),
      interval);
  ErrorNorm certification;
  const LawUse integrator =
      scene.options.integrator.id == reference_id ? LawUse{subject_id, {}} : scene.options.integrator;
  std::vector<Subject> subjects;
  subjects.reserve(time_steps.size());
  for (const double time_step : time_steps) {
    subjects.emplace_back(scene, plugins, integrator, time_step);
    subjects.back().run.of_scene = std::abs(time_step - scene.options.time_step) <= 1e-12 * time_step;
  }
  std::optional<Subject> second_order;
  if (const auto use = with_second_order(integrator, *plugins)) {
    second_order.emplace(scene, plugins, *use, scene.options.time_step);
  }
  DisplacementNorm displacement(scene.network);

  for (const double time : records.times) {
    const Simulation& truth = reference.simulation();
    if (time > 0.0) {
      advance_reference(reference, time, options.relative_tolerance);
      advance_reference(certifier, time, options.certifying_tolerance);
    }
    certification.add(time, certifier.simulation().positions(), certifier.simulation().columns(), truth.positions(),
                      truth.columns());
    displacement.add(time, truth.positions(), truth.columns());
    for (Subject& subject : subjects) advance(subject, time, truth);
    if (second_order) advance(*second_order, time, truth);
    if (options.progress && !options.progress({time, scene.duration})) {
      throw Error(ErrorKind::simulation, fmt::format("validation stopped after {:g} s", time));
    }
  }

  Validation result;
  result.scene = options.scene_name;
  result.title = scene.title;
  result.nodes = reference.simulation().node_count();
  result.springs = reference.simulation().spring_count();
  result.duration = scene.duration;
  result.times = records.times;
  result.reference = reference_id;
  result.relative_tolerance = options.relative_tolerance;
  result.certifying_tolerance = options.certifying_tolerance;
  result.certification = certification.result();
  result.displacement = displacement.result();
  result.reference_wall = reference.wall() + certifier.wall();
  result.reference_events = count_events(reference.simulation());
  for (Subject& subject : subjects) {
    finish(subject);
    if (subject.lane.divided() > 0)
      result.notes.push_back(
          fmt::format("With {:g} s: {} of {} time steps were divided; their error is that of the "
                      "smaller steps, and tells nothing of the order.",
                      subject.run.time_step, subject.lane.divided(), subject.run.steps));
    for (const std::string& note : subject.lane.simulation().notes())
      result.notes.push_back(fmt::format("With {:g} s: {}.", subject.run.time_step, note));
    result.runs.push_back(std::move(subject.run));
  }
  if (second_order) {
    finish(*second_order);
    result.second_order = std::move(second_order->run);
  }
  find_orders(result);
  if (scene.options.integrator.id == reference_id) {
    result.notes.push_back(
        fmt::format("The scene's integrator is the reference itself: what is compared with it is {} "
                    "with its defaults.",
                    subject_id));
  }
  write_notes(records, result);
  return result;
}

}  // namespace springnet
