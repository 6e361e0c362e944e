#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <system_error>

#include <fmt/format.h>
#include <springnet/readable.hpp>
#include <springnet/run.hpp>

#include "files/whole_file.hpp"
#include "profile/stage.hpp"
#include "record/record.hpp"
#include "run/checkpoint.hpp"
#include "run/outputs.hpp"
#include "run/pace.hpp"
#include "run/record_times.hpp"
#include "run/recorder.hpp"
#include "run/space.hpp"
#include "run/time_loop.hpp"
#include "text/grouped.hpp"

namespace springnet {

namespace {

std::filesystem::path nearest_existing(std::filesystem::path folder) {
  std::error_code ignored;
  folder = std::filesystem::absolute(folder, ignored);
  while (!std::filesystem::exists(folder, ignored) && folder.has_parent_path() && folder != folder.parent_path()) {
    folder = folder.parent_path();
  }
  return folder;
}

void require_space(const Scene& scene, const RunOptions& options) {
  const std::filesystem::path& folder = options.folder;
  std::error_code unknown;
  const std::filesystem::space_info space = std::filesystem::space(nearest_existing(folder), unknown);
  if (unknown) return;  // a file system that does not report its free space is no reason to refuse
  const double earlier = static_cast<double>(earlier_bytes(folder));
  double left = static_cast<double>(space.available) + earlier;
  const auto take = [&](double bytes, const char* what, const char* option) {
    if (bytes > left)
      throw Error(ErrorKind::input,
                  fmt::format("{}: {} are free, and {} may take {}; make room, write to another disk, or leave out {}",
                              folder.string(), readable_bytes(left), what, readable_bytes(bytes), option));
    left -= bytes;
  };
  if (options.trace) take(Profiler::trace_bytes(run_trace_events), "the trace", "--trace");
  if (options.checkpoint > 0.0) take(checkpoint_bytes(scene), "checkpoints", "--checkpoint");
  if (const auto refusal = space_refusal(scene, {left - earlier, earlier}, folder.string()))
    throw Error(ErrorKind::input, *refusal);
}

// `Refused`: what is thrown by work that does not fit the checkpoint, and names no file.
template <class Refused, class Work>
void as_of_checkpoint(const OutputFolder& folder, const Work& work) {
  try {
    work();
  } catch (const Refused& error) {
    if (error.kind() != ErrorKind::input) throw;
    throw Error(ErrorKind::input, fmt::format("{}: {}; undo the change, or run without --resume",
                                              (folder.path() / checkpoint_file).string(), error.what()));
  }
}

// Memory set aside, so that a run that is out of memory can still write its last record and its summary.
class MemoryReserve {
 public:
  void release() noexcept { block_.reset(); }

 private:
  static constexpr std::size_t bytes = std::size_t{4} << 20;  // a summary, its notes and half a page of view.html
  std::unique_ptr<char[]> block_ = std::make_unique_for_overwrite<char[]>(bytes);
};

// The simulation of a run with its records.
class RunTimeline : public Timeline {
 public:
  // checkpoint: s, 0: none.
  RunTimeline(const Scene& scene, Simulation& simulation, Recorder& recorder, const RunClock& clock,
              MemoryReserve& memory, double checkpoint, OutputFolder::Pointer folder, RunSummary& summary)
      : simulation_(simulation),
        recorder_(recorder),
        clock_(clock),
        memory_(memory),
        summary_(summary),
        stepper_(simulation, clock),
        state_(scene.network),
        duration_(scene.duration),
        interval_(record_interval(scene)),
        slack_(time_slack(scene.options.time_step, scene.duration)),
        next_record_(interval_),
        scene_(scene),
        folder_(std::move(folder)),
        checkpoint_interval_(checkpoint),
        next_checkpoint_(checkpoint) {}

  // How far the run and its outputs are, besides the simulation.
  void archive(Archive& archive) {
    for (double* each : {&next_record_, &recorded_, &checkpoint_interval_, &next_checkpoint_, &summary_.output_wall})
      archive.number(*each);
    archive.flag(energy_is_finite_);
    archive.number(summary_.records);
    archive.same(summary_.volumes.size(), "enclosed volumes");
    for (VolumeSummary& volume : summary_.volumes) {
      for (double* each : {&volume.first, &volume.last, &volume.smallest, &volume.greatest}) archive.number(*each);
      archive.flag(volume.leaked);
    }
    stepper_.archive(archive);
    recorder_.archive(archive);
  }

  [[nodiscard]] double time() const override { return simulation_.time(); }
  [[nodiscard]] bool has_ended() const override { return stepper_.has_reached(duration_); }

  void advance() override {
    try {
      stepper_.step(duration_);
    } catch (...) {
      memory_.release();  // the step may have run out of memory
      try {
        record_end();
      } catch (...) {  // the summary reports what ended the run, not this
      }
      throw;
    }
  }

  void record_if_due() override {
    if (has_ended() || time() >= next_record_ - slack_) {
      record();
      next_record_ = next_multiple(interval_, time(), slack_);
    }
    if (checkpoint_interval_ > 0.0 && !has_ended() && time() >= next_checkpoint_ - slack_) keep_checkpoint();
  }

  void record() {
    const profile::Stage stage("record");
    const double begin = clock_.now();
    recorded_ = time();
    state_.take(simulation_);
    recorder_.record(state_);
    // The simulation notes an energy that is not finite. A law beyond its limit may still return plausible forces.
    energy_is_finite_ = energy_is_finite_ && std::isfinite(state_.potential_energy());
    for (VolumeSummary& volume : summary_.volumes) add(volume);
    ++summary_.records;
    summary_.output_wall += clock_.now() - begin;
  }

  // The last record, however the run ends.
  void record_end() {
    if (time() > recorded_) {
      record();
    } else {
      state_.take(simulation_);  // a failed step may have changed the state at the same time
    }
    recorder_.finish(state_);
  }

  [[nodiscard]] double checkpoint_interval() const noexcept { return checkpoint_interval_; }  // s
  [[nodiscard]] const Stepper::Totals& totals() const noexcept { return stepper_.totals(); }

 private:
  void keep_checkpoint() {
    const profile::Stage stage("checkpoint");
    next_checkpoint_ = next_multiple(checkpoint_interval_, time(), slack_);
    std::string state = simulation_.save(), content;
    Archive archive(&content);
    archive.text(state);
    this->archive(archive);
    write_checkpoint(folder_, identity_of(scene_), content);
  }

  void add(VolumeSummary& volume) const {
    volume.leaked = !simulation_.element_alive(volume.element);
    if (volume.leaked && summary_.records > 0) return;
    volume.last = state_.element_value(volume.element);
    if (summary_.records == 0) volume.first = volume.smallest = volume.greatest = volume.last;
    volume.smallest = std::min(volume.smallest, volume.last);
    volume.greatest = std::max(volume.greatest, volume.last);
  }

  Simulation& simulation_;
  Recorder& recorder_;
  RunClock clock_;
  MemoryReserve& memory_;
  RunSummary& summary_;
  Stepper stepper_;
  Record state_;
  double duration_, interval_, slack_;                          // s
  double next_record_;                                          // s
  double recorded_ = -std::numeric_limits<double>::infinity();  // s, when last
  bool energy_is_finite_ = true;
  const Scene& scene_;
  OutputFolder::Pointer folder_;
  double checkpoint_interval_, next_checkpoint_;  // s
};

// Simulates to the end, or until the progress callback stops it. Throws any other reason for its end.
void simulate(RunTimeline& timeline, const Scene& scene, const Simulation& simulation, Pace* pace,
              const RunClock& clock, const RunOptions& options, RunSummary& summary) {
  const double start = clock.now();
  const auto go_on = [&] {
    return !options.progress ||
           options.progress({simulation.time(), scene.duration, simulation.steps(), clock.now() - start});
  };
  if (!options.resume) timeline.record();
  const bool ended = advance_to_end(timeline, pace, go_on);
  summary.outcome = ended ? name_of(timeline.totals().worst) : "stopped";
  timeline.record_end();
}

void add(const Stepper::Totals& totals, RunSummary& summary) {
  summary.wall = totals.wall;
  summary.spring_updates = totals.spring_updates;
  summary.unsettled = totals.unsettled;
  summary.divided = totals.divided;
  summary.substeps = totals.substeps;
  summary.stages = totals.stages;
  summary.largest_residual = totals.largest_residual;
  summary.last_residual = totals.last_residual;
}

void set_failure(RunSummary& summary, ErrorKind kind, const std::string& message) {
  if (summary.failure) return;  // the first one is the cause
  summary.failure = kind;
  summary.error = message;
  summary.outcome = "failed";
}

template <class Work>
void capture_failure(RunSummary& summary, const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    set_failure(summary, error.kind(), error.what());
  } catch (const std::bad_alloc&) {
    set_failure(summary, ErrorKind::simulation,
                "out of memory: simulate a smaller network, or on a larger machine, or make view.html smaller "
                "(output.view_size)");
  } catch (const std::exception& error) {
    set_failure(summary, ErrorKind::simulation, error.what());
  }
}

// Adds the files of the profile to those of the summary.
void write_profile(const OutputFolder::Pointer& folder, const Profiler& profiler, const RunOptions& options,
                   RunSummary& summary) {
  const auto add = [&](const char* name) {
    summary.files.emplace_back(name);
    summary.bytes += folder->size(name);
  };
  if (options.profile)
    capture_failure(summary, [&] {
      summary.profile = profiler.profile();
      write_whole({folder, profile_file}, to_json(*summary.profile, summary.steps, summary.threads));
      add(profile_file);
    });
  if (options.trace)
    capture_failure(summary, [&] {
      WholeFile file({folder, trace_file});
      profiler.write_trace(file.stream());
      file.finish();
      add(trace_file);
    });
}

// Removes summary.json, the last of the summary's files, from the list if it cannot be written.
void write_summary(const OutputFolder::Pointer& folder, RunSummary& summary) {
  bool written = false;
  capture_failure(summary, [&] {
    write_whole({folder, summary_file}, to_json(summary));
    written = true;
  });
  if (!written) summary.files.pop_back();
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
  for (ElementIndex e = 0; e < scene.network.elements().size(); ++e) {
    if (scene.network.elements()[e].invariant != Invariant::enclosed_volume) continue;
    const auto set = std::find_if(scene.elements.begin(), scene.elements.end(), [e](const ElementSet& each) {
      return e >= each.first && e - each.first < each.count;
    });
    summary.volumes.push_back({e, set == scene.elements.end() ? "" : set->name, 0.0, 0.0, 0.0, 0.0});
  }
  summary.nodes = simulation.node_count();
  summary.springs = simulation.spring_count();
  summary.elements = simulation.element_count();
  return summary;
}

}  // namespace

RunSummary run_scene(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const RunOptions& options) {
  require_space(scene, options);
  const RunClock clock = clock_or_system(options.clock);
  std::optional<Pace> pace;
  if (options.realtime != 0.0) pace.emplace(options.realtime, 0.0, clock);
  if (!(options.checkpoint >= 0.0 && std::isfinite(options.checkpoint)))
    throw Error(ErrorKind::input,
                fmt::format("checkpoint: must be a time above 0 s, or 0 for none, is {} s", options.checkpoint));
  check_starts(scene);
  SimulationOptions simulated = scene.options;
  if (scene.output.energies) simulated.dissipated_energy = true;
  if (!simulated.profiler && (options.profile || options.trace))
    simulated.profiler = std::make_shared<Profiler>(options.trace ? run_trace_events : 0);
  std::optional<Profiler::Scope> whole(std::in_place, simulated.profiler.get(), "run");
  std::optional<profile::Stage> setting_up(std::in_place, "set up");
  if (options.loading && scene.network.springs().size() >= slow_to_load)
    options.loading({fmt::format("setting up {} nodes and {} springs", grouped(scene.network.nodes().size()),
                                 grouped(scene.network.springs().size())),
                     std::numeric_limits<double>::quiet_NaN()});
  // Without a copy: the scene stays as it is.
  Simulation simulation(std::shared_ptr<const Network>(std::shared_ptr<const void>(), &scene.network), plugins,
                        simulated);
  RunSummary summary = describe(scene, simulation, *plugins, options.scene_name);
  const OutputFolder::Pointer folder = OutputFolder::make(options.folder);
  folder->lock();
  MemoryReserve memory;
  std::optional<Recorder> recorder;  // none if not even the headers of its files could be written
  std::optional<RunTimeline> timeline;
  const auto begin = [&] {
    recorder.emplace(scene, plugins, folder, options.resume);
    timeline.emplace(scene, simulation, *recorder, clock, memory, options.checkpoint, folder, summary);
  };
  if (options.resume) {
    const std::string content = read_checkpoint(folder, identity_of(scene));
    Archive archive{std::string_view(content)};
    // Until all is there and fits, nothing is changed in the folder.
    as_of_checkpoint<Error>(*folder, [&] {
      std::string state;
      archive.text(state);
      simulation.restore(state);
    });
    begin();
    as_of_checkpoint<ArchiveError>(*folder, [&] { timeline->archive(archive); });
    if (options.checkpoint > 0.0 && options.checkpoint != timeline->checkpoint_interval())
      throw Error(ErrorKind::input,
                  fmt::format("--checkpoint is {} s, and was {} s in the run that is to be resumed; leave it out",
                              options.checkpoint, timeline->checkpoint_interval()));
    recorder->go_on();
    remove_reports(folder);
    if (pace) pace.emplace(options.realtime, simulation.time(), clock);
  }
  capture_failure(summary, [&] {
    if (!timeline) begin();
    setting_up.reset();
    simulate(*timeline, scene, simulation, pace ? &*pace : nullptr, clock, options, summary);
  });
  setting_up.reset();
  memory.release();
  if (!recorder && summary.failure == ErrorKind::input) throw Error(ErrorKind::input, summary.error);
  if (summary.failure == ErrorKind::simulation && simulation.last_report().outcome != Outcome::settled) {
    summary.outcome = name_of(simulation.last_report().outcome);
  }
  if (summary.failure && recorder) recorder->failed(summary.error);
  if (recorder) {
    const profile::Stage stage("close");
    capture_failure(summary, [&] { recorder->close(); });
  }
  whole.reset();
  // A run that failed or was stopped can be resumed.
  if (!summary.failure && summary.outcome != "stopped") folder->remove(checkpoint_file);

  if (timeline) add(timeline->totals(), summary);
  if (pace) summary.pace = pace->report();
  summary.springs_left = simulation.live_spring_count();
  for (ElementIndex e = 0; e < summary.elements; ++e) summary.elements_left += simulation.element_alive(e) ? 1 : 0;
  summary.steps = simulation.steps();
  summary.sweeps = simulation.sweeps();
  summary.simulated = simulation.time();
  summary.statistics = simulation.statistics();
  summary.events = count_events(simulation);
  summary.notes = options.notes;
  for (const auto& notes :
       {notes_of(scene), simulation.notes(), recorder ? recorder->notes() : std::vector<std::string>{}}) {
    summary.notes.insert(summary.notes.end(), notes.begin(), notes.end());
  }
  if (recorder) {
    summary.bytes = recorder->bytes();
    summary.files = recorder->files();
    summary.cut_short = recorder->cut_short();
  }
  if (options.profile || options.trace) write_profile(folder, *simulated.profiler, options, summary);
  summary.files.emplace_back(summary_file);
  write_summary(folder, summary);
  return summary;
}

}  // namespace springnet
