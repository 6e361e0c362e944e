#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/validation.hpp>

#include "run/time_loop.hpp"
#include "validation/displacement.hpp"
#include "validation/error_norm.hpp"
#include "validation/notes.hpp"

namespace springnet {

namespace {

constexpr const char* reference_id = "cvode";
constexpr const char* subject_id = "recurrent";

SimulationOptions options_for(const Scene& scene, const LawUse& integrator, double time_step) {
  SimulationOptions options = scene.options;
  options.integrator = integrator;
  options.time_step = time_step;
  return options;
}

// One of the simulations that advance together.
struct Lane {
  Lane(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const LawUse& integrator, double time_step)
      : simulation(scene.network, plugins, options_for(scene, integrator, time_step)),
        stepper(simulation, clock_or_system({})) {}
  Lane(const Lane&) = delete;
  Lane& operator=(const Lane&) = delete;

  Simulation simulation;
  Stepper stepper;
};

// A run of the integrator under validation.
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

std::vector<double> time_steps_of(const Scene& scene, const std::vector<double>& requested) {
  const double own = scene.options.time_step;
  std::vector<double> result = requested.empty() ? std::vector<double>{own / 2.0, own / 4.0} : requested;
  result.push_back(own);
  std::sort(result.begin(), result.end(), std::greater<>());
  // The scene's own time step may be among the requested ones, differently rounded.
  const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-12 * a; };
  result.erase(std::unique(result.begin(), result.end(), same), result.end());
  return result;
}

void finish(Subject& subject) {
  ValidationRun& run = subject.run;
  const Simulation& simulation = subject.lane.simulation;
  run.error = subject.norm.result();
  run.steps = simulation.steps();
  run.sweeps = simulation.sweeps();
  run.wall = subject.lane.stepper.totals().wall;
  if (run.finished()) run.outcome = name_of(subject.lane.stepper.totals().worst);
  run.events = count_events(simulation);
}

void add(ErrorNorm& norm, double time, const Simulation& simulation, const Simulation& reference) {
  norm.add(time, simulation.positions(), simulation.columns(), reference.positions(), reference.columns());
}

// All simulations of a validation, from record time to record time.
class Comparison : public Timeline {
 public:
  Comparison(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const ValidationOptions& options,
             const std::vector<double>& time_steps, const RecordTimes& records);

  [[nodiscard]] double time() const override { return records_.times[record_]; }
  [[nodiscard]] bool has_ended() const override { return record_ + 1 == records_.times.size(); }
  void advance() override;
  // The errors at this time. Every stage ends at a record time.
  void record_if_due() override;

  Lane reference, certifier;
  ErrorNorm certification;
  DisplacementNorm displacement;
  std::vector<std::unique_ptr<Subject>> subjects;
  std::unique_ptr<Subject> second_order;  // null where the integrator has no theta to set

 private:
  void advance_reference(Lane& lane, double tolerance);
  // A run that fails stops, and keeps the reason.
  void advance(Subject& subject);
  template <class Work>
  void each_subject(const Work& work) {
    for (const auto& subject : subjects) work(*subject);
    if (second_order) work(*second_order);
  }

  const ValidationOptions& options_;
  const RecordTimes& records_;
  std::size_t record_ = 0;
};

Comparison::Comparison(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins,
                       const ValidationOptions& options, const std::vector<double>& time_steps,
                       const RecordTimes& records)
    : reference(scene, plugins, reference_use(scene, options.relative_tolerance, 1.0), records.times[1]),
      certifier(
          scene, plugins,
          reference_use(scene, options.certifying_tolerance, options.certifying_tolerance / options.relative_tolerance),
          records.times[1]),
      displacement(scene.network),
      options_(options),
      records_(records) {
  const LawUse integrator =
      scene.options.integrator.id == reference_id ? LawUse{subject_id, {}} : scene.options.integrator;
  for (const double time_step : time_steps) {
    subjects.push_back(std::make_unique<Subject>(scene, plugins, integrator, time_step));
    subjects.back()->run.of_scene = std::abs(time_step - scene.options.time_step) <= 1e-12 * time_step;
  }
  if (const auto use = with_second_order(integrator, *plugins)) {
    second_order = std::make_unique<Subject>(scene, plugins, *use, scene.options.time_step);
  }
}

void Comparison::advance() {
  ++record_;
  advance_reference(reference, options_.relative_tolerance);
  advance_reference(certifier, options_.certifying_tolerance);
  each_subject([&](Subject& subject) { advance(subject); });
}

void Comparison::advance_reference(Lane& lane, double tolerance) {
  try {
    lane.stepper.advance_to(time());
  } catch (const Error& error) {
    throw Error(error.kind(),
                fmt::format("the reference ({}, relative tolerance {:g}) failed after {:g} s, so there is "
                            "nothing to compare with: {}",
                            reference_id, tolerance, lane.simulation.time(), error.what()));
  }
}

void Comparison::advance(Subject& subject) {
  if (!subject.run.finished()) return;
  const Simulation& simulation = subject.lane.simulation;
  try {
    subject.lane.stepper.advance_to(time());
    subject.run.reached = time();
  } catch (const Error& error) {
    const Outcome outcome = simulation.last_report().outcome;
    subject.run.failure = error.what();
    subject.run.failure_kind = error.kind();
    subject.run.outcome = outcome == Outcome::settled ? "failed" : std::string(name_of(outcome));
    subject.run.reached = simulation.time();
  }
}

void Comparison::record_if_due() {
  const Simulation& truth = reference.simulation;
  add(certification, time(), certifier.simulation, truth);
  displacement.add(time(), truth.positions(), truth.columns());
  each_subject([&](Subject& subject) {
    if (subject.run.finished()) add(subject.norm, time(), subject.lane.simulation, truth);
  });
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
  // Differences below the reference's uncertainty mean nothing.
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
  const std::vector<Change>& changes = scene.network.changes();
  for (std::size_t k = 0; k < changes.size(); ++k)
    if (changes[k].integrator)
      throw Error(ErrorKind::input,
                  fmt::format("change {} exchanges the integrator at {:g} s: validate compares one integrator with a "
                              "reference; leave the exchange out, and validate each integrator by itself",
                              k, changes[k].time));
  check_starts(scene);
  if (!(options.relative_tolerance > options.certifying_tolerance) || !(options.certifying_tolerance > 0.0)) {
    throw Error(
        ErrorKind::input,
        fmt::format("the run that certifies the reference needs a relative tolerance above 0 and below that of the "
                    "reference ({:g}), but has {:g}",
                    options.relative_tolerance, options.certifying_tolerance));
  }
  const std::vector<double> time_steps = time_steps_of(scene, options.time_steps);
  const RecordTimes records = common_record_times(scene.duration, scene.output.interval, time_steps);
  Comparison comparison(scene, plugins, options, time_steps, records);
  const auto go_on = [&] { return !options.progress || options.progress({comparison.time(), scene.duration}); };
  comparison.record_if_due();
  if (!go_on() || !advance_to_end(comparison, nullptr, go_on)) {
    throw Error(ErrorKind::simulation, fmt::format("validation stopped after {:g} s", comparison.time()));
  }

  Validation result;
  result.scene = options.scene_name;
  result.title = scene.title;
  result.nodes = comparison.reference.simulation.node_count();
  result.springs = comparison.reference.simulation.spring_count();
  result.duration = scene.duration;
  result.times = records.times;
  result.reference = reference_id;
  result.relative_tolerance = options.relative_tolerance;
  result.certifying_tolerance = options.certifying_tolerance;
  result.certification = comparison.certification.result();
  result.displacement = comparison.displacement.result();
  result.reference_wall = comparison.reference.stepper.totals().wall + comparison.certifier.stepper.totals().wall;
  result.reference_events = count_events(comparison.reference.simulation);
  for (const auto& subject : comparison.subjects) {
    finish(*subject);
    if (const std::uint64_t divided = subject->lane.stepper.totals().divided; divided > 0) {
      result.notes.push_back(
          fmt::format("With {:g} s, {} of {} time steps were divided: their error is that of the smaller steps and "
                      "does not show the order.",
                      subject->run.time_step, divided, subject->run.steps));
    }
    for (const std::string& note : subject->lane.simulation.notes())
      result.notes.push_back(fmt::format("With {:g} s: {}.", subject->run.time_step, note));
    result.runs.push_back(std::move(subject->run));
  }
  if (comparison.second_order) {
    finish(*comparison.second_order);
    result.second_order = std::move(comparison.second_order->run);
  }
  find_orders(result);
  if (scene.options.integrator.id == reference_id) {
    result.notes.push_back(fmt::format(
        "The scene's integrator is the reference itself; it is compared with {} with default options.", subject_id));
  }
  write_notes(records, result);
  return result;
}

}  // namespace springnet
