#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <system_error>

#include <fmt/format.h>
#include <springnet/output.hpp>

#include "run/pace.hpp"
#include "run/recorder.hpp"
#include "run/space.hpp"
#include "files/whole_file.hpp"

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

void require_space(const Scene& scene, const std::filesystem::path& folder) {
  std::error_code unknown;
  const std::filesystem::space_info space = std::filesystem::space(nearest_existing(folder), unknown);
  if (unknown) return;  // a file system that does not say how much is free is not a reason to refuse
  const auto refusal = space_refusal(
      scene, {static_cast<double>(space.available), static_cast<double>(earlier_bytes(folder))}, folder.string());
  if (refusal) throw Error(ErrorKind::input, *refusal);
}

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

// Memory to write the end of a run with that runs out of it.
class MemoryReserve {
 public:
  void release() noexcept { block_.reset(); }

 private:
  static constexpr std::size_t bytes = std::size_t{4} << 20;  // a summary, its notes and half a page of view.html
  std::unique_ptr<char[]> block_ = std::make_unique_for_overwrite<char[]>(bytes);
};

void simulate(const Scene& scene, Simulation& simulation, Recorder& recorder, const RunOptions& options,
              MemoryReserve& memory, RunSummary& summary) {
  const RunClock clock = clock_of(options);
  const double time_step = scene.options.time_step;
  // A remainder as small as this is rounding of the times (Simulation::advance_to takes it so).
  const double slack = 1e-6 * std::min(time_step, scene.duration);
  const double interval = std::max(scene.output.interval, time_step);
  StepCounter counter;
  const double start = clock.now();
  double recorded = -std::numeric_limits<double>::infinity();  // s, when last
  bool energy_is_finite = true;
  const auto write_record = [&] {
    const double begin = clock.now();
    recorded = simulation.time();
    recorder.record(simulation);
    // Notes where it is not finite. A law may answer forces beyond its limit that look like any other.
    energy_is_finite = energy_is_finite && std::isfinite(simulation.potential_energy());
    for (VolumeSummary& volume : summary.volumes) {
      volume.leaked = !simulation.element_alive(volume.element);
      if (volume.leaked && summary.records > 0) continue;
      volume.last = simulation.element_value(volume.element);
      if (summary.records == 0) volume.first = volume.smallest = volume.greatest = volume.last;
      volume.smallest = std::min(volume.smallest, volume.last);
      volume.greatest = std::max(volume.greatest, volume.last);
    }
    ++summary.records;
    summary.output_wall += clock.now() - begin;
  };
  // Whatever ends the run: how far it came, and what happened until then.
  const auto write_end = [&] {
    if (simulation.time() > recorded) write_record();
    recorder.finish(simulation);
  };
  const auto wanted = [&] {
    return !options.progress ||
           options.progress({simulation.time(), scene.duration, simulation.steps(), clock.now() - start});
  };

  write_record();
  double next_record = interval;
  summary.outcome = name_of(counter.worst());
  std::optional<Pace> pace;
  if (options.realtime != 0.0) pace.emplace(options.realtime, simulation.time(), clock);
  const auto keep_report = [&] {
    if (pace) summary.pace = pace->report();
  };
  keep_report();
  while (simulation.time() < scene.duration - slack) {
    if (pace && !pace->wait(simulation.time(), wanted)) {
      summary.outcome = "stopped";
      break;
    }
    const bool last = simulation.time() + time_step >= scene.duration - slack;
    const double springs = static_cast<double>(simulation.live_spring_count());
    const double begin = clock.now();
    const auto count_work = [&] {
      summary.wall += clock.now() - begin;
      summary.spring_updates += static_cast<double>(simulation.last_report().sweeps) * springs;
    };
    try {
      if (last) {
        simulation.advance_to(scene.duration);
      } else {
        simulation.step();
      }
    } catch (...) {
      memory.release();  // so that there is some to end with, if it is that which is short
      count_work();
      try {
        write_end();
      } catch (...) {  // what ended the run is told, not what could not be written of it
      }
      throw;
    }
    count_work();
    if (pace) pace->finished(simulation.time());
    keep_report();
    counter.count(simulation.last_report(), summary);
    summary.outcome = name_of(counter.worst());

    if (last || simulation.time() >= next_record - slack) {
      write_record();
      next_record = interval * (std::floor((simulation.time() + slack) / interval) + 1.0);
    }
    if (!wanted()) {
      if (!last) summary.outcome = "stopped";
      break;
    }
  }
  write_end();
}

void take_failure(RunSummary& summary, ErrorKind kind, const std::string& message) {
  if (summary.failure) return;  // the first one is the cause
  summary.failure = kind;
  summary.error = message;
  summary.outcome = "failed";
}

template <class Work>
void keep_failure(RunSummary& summary, const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    take_failure(summary, error.kind(), error.what());
  } catch (const std::bad_alloc&) {
    take_failure(summary, ErrorKind::simulation,
                 "out of memory: simulate a smaller network, or on a larger machine, or make view.html smaller "
                 "(output.view_size)");
  } catch (const std::exception& error) {
    take_failure(summary, ErrorKind::simulation, error.what());
  }
}

// The last of the summary's files is this one.
void write_summary(const OutputFolder::Pointer& folder, RunSummary& summary) {
  bool written = false;
  keep_failure(summary, [&] {
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
  summary.largest_residual = summary.last_residual = std::numeric_limits<double>::quiet_NaN();
  return summary;
}

}  // namespace

RunSummary run_scene(const Scene& scene, const std::shared_ptr<const PluginHost>& plugins, const RunOptions& options) {
  require_space(scene, options.folder);
  if (options.realtime != 0.0) static_cast<void>(Pace(options.realtime, 0.0, clock_of(options)));  // refuses nonsense
  check_starts(scene);
  Simulation simulation(scene.network, plugins, scene.options);
  RunSummary summary = describe(scene, simulation, *plugins, options.scene_name);
  const OutputFolder::Pointer folder = OutputFolder::make(options.folder);
  folder->lock();
  MemoryReserve memory;
  std::optional<Recorder> recorder;  // none where not even the heads of its files could be written
  keep_failure(summary, [&] {
    recorder.emplace(scene, plugins, folder);
    simulate(scene, simulation, *recorder, options, memory, summary);
  });
  memory.release();
  if (!recorder && summary.failure == ErrorKind::input) throw Error(ErrorKind::input, summary.error);
  if (summary.failure == ErrorKind::simulation && simulation.last_report().outcome != Outcome::settled) {
    summary.outcome = name_of(simulation.last_report().outcome);
  }
  if (summary.failure && recorder) recorder->failed(summary.error);
  if (recorder) keep_failure(summary, [&] { recorder->close(); });

  summary.springs_left = simulation.live_spring_count();
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
  summary.files.emplace_back(summary_file);
  write_summary(folder, summary);
  return summary;
}

}  // namespace springnet
