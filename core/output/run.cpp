#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <system_error>

#include <fmt/format.h>
#include <springnet/output.hpp>
#include <springnet/view.hpp>

namespace springnet {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr const char* trajectory_file = "trajectory.csv";
constexpr const char* reactions_file = "reactions.csv";
constexpr const char* surfaces_file = "surfaces.csv";
constexpr const char* rigid_file = "rigid.csv";
constexpr const char* events_file = "events.csv";
constexpr const char* view_file = "view.html";
constexpr const char* summary_file = "summary.json";

// Share of the free space that a run leaves to others.
constexpr double space_kept = 0.02;

std::filesystem::path nearest_existing(std::filesystem::path folder) {
  std::error_code ignored;
  folder = std::filesystem::absolute(folder, ignored);
  while (!std::filesystem::exists(folder, ignored) && folder.has_parent_path() && folder != folder.parent_path()) {
    folder = folder.parent_path();
  }
  return folder;
}

void require_space(const Scene& scene, const std::filesystem::path& folder) {
  const OutputEstimate estimate = estimate_output(scene);
  const double bytes = estimate.bytes + estimate_view(scene);
  std::error_code unknown;
  const std::filesystem::space_info space = std::filesystem::space(nearest_existing(folder), unknown);
  if (unknown) return;  // a file system that does not say how much is free is not a reason to refuse
  const double available = static_cast<double>(space.available) * (1.0 - space_kept);
  if (bytes <= available) return;
  const double interval = std::max(scene.output.interval, scene.options.time_step);
  throw Error(
      ErrorKind::input,
      fmt::format("the output would be about {} ({:.3g} records), but only {} are free in {}; record less often "
                  "(output.interval above {:.2g} s), leave out the trajectory (output.trajectory = false), or "
                  "write to another disk",
                  readable_bytes(bytes), estimate.records, readable_bytes(static_cast<double>(space.available)),
                  folder.string(), interval * bytes / std::max(available, 1.0)));
}

void prepare_folder(const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed || !std::filesystem::is_directory(folder)) {
    throw Error(ErrorKind::input, fmt::format("{}: the folder for the output cannot be made: {}; name another one",
                                              folder.string(), failed ? failed.message() : "a file is in the way"));
  }
  // Files of an earlier run would be taken for those of this one.
  for (const char* name :
       {trajectory_file, reactions_file, surfaces_file, rigid_file, events_file, view_file, summary_file}) {
    std::filesystem::remove(folder / name, failed);
  }
}

// The tables of one run.
class Recorder {
 public:
  Recorder(const Scene& scene, const std::filesystem::path& folder, std::vector<std::string>& files)
      : events_(folder / events_file) {
    files = {events_file};
    if (scene.output.trajectory) {
      trajectory_.emplace(folder / trajectory_file);
      files.emplace_back(trajectory_file);
    }
    if (scene.output.reactions) {
      reactions_.emplace(folder / reactions_file, scene.network);
      files.emplace_back(reactions_file);
    }
    if (scene.output.surfaces && scene.network.planes().size() + scene.network.instruments().size() > 0) {
      surfaces_.emplace(folder / surfaces_file);
      files.emplace_back(surfaces_file);
    }
    if (scene.output.rigid && !scene.network.rigids().empty()) {
      rigid_.emplace(folder / rigid_file, scene.network);
      files.emplace_back(rigid_file);
    }
    if (scene.output.view) {
      view_.emplace(folder / view_file, scene, ViewOptions{scene.output.view_size});
      files.emplace_back(view_file);
    }
  }

  void record(const Simulation& simulation) {
    each([&](auto& writer) { writer.record(simulation); });
  }

  // For the reader of view.html.
  void note(const std::string& text) {
    if (view_) view_->note(text);
  }
  // What was left out of the files, for the summary.
  [[nodiscard]] std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    if (view_) notes = view_->left_out();
    for (std::string& note : notes) note = fmt::format("{}: {}", view_file, note);
    return notes;
  }

  void close() {
    each([](auto& writer) { writer.close(); });
  }

 private:
  template <class Work>
  void each(const Work& work) {
    if (trajectory_) work(*trajectory_);
    if (reactions_) work(*reactions_);
    if (surfaces_) work(*surfaces_);
    if (rigid_) work(*rigid_);
    if (view_) work(*view_);
    work(events_);
  }

  EventWriter events_;
  std::optional<TrajectoryWriter> trajectory_;
  std::optional<ReactionWriter> reactions_;
  std::optional<SurfaceWriter> surfaces_;
  std::optional<RigidWriter> rigid_;
  std::optional<ViewWriter> view_;
};

// Adds a time step to the summary; the worst outcome is that of the run.
class StepCounter {
 public:
  void count(const StepReport& report, RunSummary& summary) {
    if (report.outcome != Outcome::settled) ++summary.unsettled;
    if (report.substeps > 0) ++summary.divided;
    summary.substeps += report.substeps;
    summary.stages += report.stages;
    worst_ = std::max(worst_, report.outcome);
    if (std::isnan(report.residual)) return;
    summary.last_residual = report.residual;
    summary.largest_residual =
        std::isnan(summary.largest_residual) ? report.residual : std::max(summary.largest_residual, report.residual);
  }
  [[nodiscard]] Outcome worst() const { return worst_; }

 private:
  Outcome worst_ = Outcome::settled;
};

void simulate(const Scene& scene, Simulation& simulation, Recorder& recorder, const RunOptions& options,
              RunSummary& summary) {
  const double time_step = scene.options.time_step;
  // A remainder as small as this is rounding of the times (Simulation::advance_to takes it so).
  const double slack = 1e-6 * time_step;
  const double interval = std::max(scene.output.interval, time_step);
  StepCounter counter;
  const auto start = Clock::now();
  const auto write_record = [&] {
    const auto begin = Clock::now();
    recorder.record(simulation);
    ++summary.records;
    summary.output_wall += seconds_since(begin);
  };

  write_record();
  double next_record = interval;
  summary.outcome = name_of(counter.worst());
  while (simulation.time() < scene.duration - slack) {
    const bool last = simulation.time() + time_step >= scene.duration - slack;
    const double springs = static_cast<double>(simulation.live_spring_count());
    const auto begin = Clock::now();
    const auto count_work = [&] {
      summary.wall += seconds_since(begin);
      summary.spring_updates += static_cast<double>(simulation.last_report().sweeps) * springs;
    };
    try {
      if (last) {
        simulation.advance_to(scene.duration);
      } else {
        simulation.step();
      }
    } catch (const Error&) {
      count_work();
      throw;
    }
    count_work();
    counter.count(simulation.last_report(), summary);
    summary.outcome = name_of(counter.worst());

    if (last || simulation.time() >= next_record - slack) {
      write_record();
      next_record = interval * (std::floor((simulation.time() + slack) / interval) + 1.0);
    }
    if (options.progress &&
        !options.progress({simulation.time(), scene.duration, simulation.steps(), seconds_since(start)})) {
      if (!last) summary.outcome = "stopped";
      return;
    }
  }
}

void take_failure(RunSummary& summary, ErrorKind kind, const std::string& message) {
  if (summary.failure) return;  // the first one is the cause
  summary.failure = kind;
  summary.error = message;
  summary.outcome = "failed";
}

void write_summary(const std::filesystem::path& file, RunSummary& summary) {
  std::ofstream out(file, std::ios::binary);
  out << to_json(summary);
  out.close();
  if (out) return;
  take_failure(summary, ErrorKind::simulation,
               fmt::format("{}: cannot be written; make room or write to another disk", file.string()));
}

template <class Work>
void keep_failure(RunSummary& summary, const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    take_failure(summary, error.kind(), error.what());
  } catch (const std::exception& error) {
    take_failure(summary, ErrorKind::simulation, error.what());
  }
}

RunSummary describe(const Scene& scene, const Simulation& simulation, const PluginHost& plugins,
                    const std::string& name) {
  RunSummary summary;
  summary.scene = name;
  summary.title = scene.title;
  summary.integrator = scene.options.integrator;
  const auto integrator = plugins.require(ComponentKind::integrator, scene.options.integrator.id);
  for (const auto& [option, value] : summary.integrator.parameters) {
    const std::ptrdiff_t index = parameter_index(*integrator->description, option);
    if (index < 0) continue;
    const springnet_parameter& parameter = *integrator->description->parameters[index];
    if (parameter.type != SPRINGNET_CHOICE || !(value >= 0.0) || value >= parameter.choice_count) continue;
    summary.choices[option] = parameter.choices[static_cast<std::size_t>(value)];
  }
  summary.time_step = scene.options.time_step;
  summary.duration = scene.duration;
  summary.threads = simulation.threads();
  switch (simulation.instruction_set()) {
    case InstructionSet::best:
    case InstructionSet::generic:
      summary.instruction_set = "generic";
      break;
    case InstructionSet::avx2:
      summary.instruction_set = "avx2";
      break;
    case InstructionSet::avx512:
      summary.instruction_set = "avx512";
      break;
  }
  summary.plugins = plugins_used(scene, plugins);
  summary.nodes = simulation.node_count();
  summary.springs = simulation.spring_count();
  summary.largest_residual = summary.last_residual = std::numeric_limits<double>::quiet_NaN();
  return summary;
}

}  // namespace

RunSummary run_scene(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const RunOptions& options) {
  require_space(scene, options.folder);
  Simulation simulation(scene.network, plugins, scene.options);
  RunSummary summary = describe(scene, simulation, *plugins, options.scene_name);
  prepare_folder(options.folder);
  Recorder recorder(scene, options.folder, summary.files);

  keep_failure(summary, [&] { simulate(scene, simulation, recorder, options, summary); });
  if (summary.failure == ErrorKind::simulation && simulation.last_report().outcome != Outcome::settled) {
    summary.outcome = name_of(simulation.last_report().outcome);
  }
  if (summary.failure) recorder.note("The run failed: " + summary.error);
  keep_failure(summary, [&] { recorder.close(); });

  summary.springs_left = simulation.live_spring_count();
  summary.steps = simulation.steps();
  summary.sweeps = simulation.sweeps();
  summary.simulated = simulation.time();
  summary.statistics = simulation.statistics();
  summary.events = count_events(simulation);
  summary.notes = options.notes;
  for (const auto& notes : {notes_of(scene), simulation.notes(), recorder.notes()}) {
    summary.notes.insert(summary.notes.end(), notes.begin(), notes.end());
  }
  std::error_code ignored;
  for (const std::string& file : summary.files)
    summary.bytes += std::filesystem::file_size(options.folder / file, ignored);
  summary.files.emplace_back(summary_file);
  write_summary(options.folder / summary_file, summary);
  return summary;
}

}  // namespace springnet
