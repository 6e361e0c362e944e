#include <cmath>
#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/run.hpp>
#include <springnet/tables.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "crash.hpp"
#include "process.hpp"
#include "profile_table.hpp"
#include "progress.hpp"
#include "text/counted.hpp"

namespace springnet::tool {

namespace {

constexpr const char* run_examples =
    R"(Examples (the cube is that of 'springnet new --example cube'):
  springnet run cube/cube.toml
  springnet run cube/cube.toml --time-step 0.01 --duration 5 -o /tmp/cube
  springnet run cube/cube.toml --integrator cvode --set simulation.integrator.method=\"adams\"
  springnet run cube/cube.toml --set output.interval=0.5 --set output.vtk=true
  springnet run cube/cube.toml --profile         shows which stages and laws take the time
  springnet run cube/cube.toml --checkpoint 0.5  can be resumed once it was killed, with --resume
  springnet run cube/cube.toml --realtime=4      keeps pace with four times real time, and counts late time steps

Exit status:
  0 done   1 the simulation failed (its output up to then is kept)   2 usage or scene   3 plugin)";

// "time,node,fx,fy,fz,tx,…": as many columns as fit.
std::string heading(const std::string& header) {
  constexpr std::size_t max_length = 24;
  if (header.size() <= max_length) return header;
  return header.substr(0, header.rfind(',', max_length - 2) + 1) + "…";
}

std::string run_footer() {
  std::string text =
      "Files in the output folder ([output] of the scene selects them, their content and how often they are "
      "written):\n";
  std::vector<std::string> binary;
  for (const TableSummary& table : table_summaries()) {
    text += fmt::format("  {:16} {:26} {}\n", table.file, heading(table.header), table.content);
    if (table.has_binary_form) binary.push_back(table.name);
  }
  return text +
         fmt::format(R"(  vtk/run.pvd      for ParaView, if output.vtk = true
  view.html        a page that plays the run, unless output.view = false
  summary.json     outcome and statistics of the run
  profile.json     time of each stage, with --profile
  trace.json       their course for ui.perfetto.dev or chrome://tracing, with --trace
  checkpoint       with --checkpoint, while the run has not reached its end
With output.format = "binary" these are .bin files, which 'springnet convert' converts to text: {}.

)",
                     fmt::join(binary, ", ")) +
         run_examples;
}

struct RunArguments {
  SceneArguments scene;
  OutputArguments output;
  bool profile = false;
  bool trace = false;
  double checkpoint = 0.0;
  bool resume = false;
  std::string realtime;  // simulated seconds per second of the clock, "true": 1; empty: as fast as possible
};

// CLI11 gives a flag without a value the value "true".
CLI::Validator factor_or_true() {
  const CLI::Validator number = number_between(above_zero, finite);
  return CLI::Validator([number](const std::string& text) { return text == "true" ? std::string() : number(text); },
                        "");
}

// For '--realtime 2': a flag takes its value only after '=', so the 2 is an unknown argument.
void refuse_separate_factor(CLI::App& command, const RunArguments& arguments) {
  const std::vector<std::string> words = command.remaining();
  if (arguments.realtime != "true" || words.size() != 1) return;
  for (const std::string& word : {words.front(), arguments.scene.file.string()}) {
    if (!number_between(above_zero, finite)(word).empty()) continue;
    const std::string message = fmt::format("unknown argument '{0}'; did you mean '--realtime={0}'?", word);
    command.clear();  // forget the word, or it would be reported instead
    throw CLI::ParseError(message, CLI::ExitCodes::ExtrasError);
  }
}

// Speed of the simulation alone, without output.
std::string multiple_of_real_time(const RunSummary& summary) {
  if (!(summary.simulated > 0.0)) return "no time step";
  if (!(summary.wall > 0.0)) return "no time";
  return fmt::format("{:.3g} times real time", summary.simulated / summary.wall);
}

std::string readable_delay(double seconds) {
  return seconds < 1.0 ? fmt::format("{:.3g} ms", 1000.0 * seconds) : fmt::format("{:.3g} s", seconds);
}

std::string estimate_text(const OutputEstimate& estimate, const std::filesystem::path& folder) {
  std::string text = fmt::format("writing about {} ({}) to {}\n", readable_bytes(estimate.bytes),
                                 estimate.records == 1.0 ? "1 record" : fmt::format("{:.0f} records", estimate.records),
                                 folder.string());
  for (const FileEstimate& file : estimate.files) {
    text += fmt::format("  {:15}  {}{}\n", file.file, file.exact ? "" : "at most ", readable_bytes(file.bytes));
  }
  return text;
}

// Empty for nets of elements alone.
std::string springs_per_second(const RunSummary& summary) {
  if (summary.springs == 0) return {};
  return fmt::format(", {:.3g} million springs per second",
                     summary.wall > 0.0 ? summary.spring_updates / summary.wall / 1e6 : 0.0);
}

// Notes from number `first` on; the earlier ones were printed before the run.
std::string result_text(const RunSummary& summary, const std::filesystem::path& folder, std::size_t first) {
  const auto steps = static_cast<double>(summary.steps);
  std::string text;
  text += fmt::format("{}: {}, {}", summary.scene, summary.integrator.id, counted(summary.nodes, "node"));
  if (summary.springs > 0 || summary.elements == 0) text += ", " + counted(summary.springs, "spring");
  if (summary.elements > 0) text += ", " + counted(summary.elements, "element");
  text += "\n";
  text += fmt::format("  outcome    {}\n", summary.outcome);
  text +=
      fmt::format("  simulated  {:g} s of {:g} s in {:.3g} s ({}): {}, {:.1f} sweeps per step{}\n", summary.simulated,
                  summary.duration, summary.wall, multiple_of_real_time(summary), counted(summary.steps, "step"),
                  steps > 0.0 ? static_cast<double>(summary.sweeps) / steps : 0.0, springs_per_second(summary));
  if (summary.pace) {
    const PaceReport& pace = *summary.pace;
    text += fmt::format("  pace       {:g} times real time, {:.3g} frames per second: {}, {} missed{}\n", pace.factor,
                        pace.factor / summary.time_step, counted(pace.frames, "frame"), pace.missed,
                        pace.missed > 0 ? fmt::format(", up to {} late", readable_delay(pace.greatest_delay)) : "");
  }
  if (summary.unsettled > 0) {
    text += fmt::format("  warning    {} of {} accepted without having settled\n", summary.unsettled,
                        counted(summary.steps, "time step"));
  }
  if (summary.divided > 0) {
    text += fmt::format("  substeps   {} of {} divided, {} in total\n", summary.divided,
                        counted(summary.steps, "time step"), counted(summary.substeps, "smaller step"));
  }
  if (summary.stages > 0) {
    text += fmt::format("  stages     {} before the full one\n", counted(summary.stages, "smaller time constant"));
  }
  if (std::isfinite(summary.largest_residual))
    text += fmt::format("  residual   {:.2g} N at most\n", summary.largest_residual);
  for (const VolumeSummary& volume : summary.volumes) {
    text += fmt::format("  volume     {}: {:.4g} m^3 at the start, {:.4g} at the end{}, between {:.4g} and {:.4g}\n",
                        volume.name.empty() ? fmt::format("element {}", volume.element) : volume.name, volume.first,
                        volume.last, volume.leaked ? ", before it leaked" : "", volume.smallest, volume.greatest);
  }
  text += fmt::format("  events     {}\n", describe(summary.events));
  text += fmt::format("  written    {} ({} and the summary) in {}\n", fmt::join(summary.files, ", "),
                      readable_bytes(static_cast<double>(summary.bytes)), folder.string());
  for (std::size_t k = first; k < summary.notes.size(); ++k) text += fmt::format("  note       {}\n", summary.notes[k]);
  return text;
}

// What follows a sentence before its full stop.
std::string resume_hint(const std::filesystem::path& folder) {
  std::error_code unknown;
  if (!std::filesystem::exists(folder / "checkpoint", unknown)) return "";
  return "; with --resume the run goes on from its last checkpoint";
}

// "The output up to 101 s is kept in out, except trajectory.csv: up to 80 s."
std::string kept_text(const RunSummary& summary, const std::filesystem::path& folder) {
  if (summary.records == 0) return "Nothing was recorded.";
  if (summary.bytes == 0) return "No output is kept.";
  std::vector<std::string> shorter;
  for (const CutShort& file : summary.cut_short) {
    shorter.push_back(std::isnan(file.until) ? fmt::format("{}: no record", file.file)
                                             : fmt::format("{}: up to {:g} s", file.file, file.until));
  }
  return fmt::format("The output up to {:g} s is kept in {}{}{}.", summary.simulated, folder.string(),
                     shorter.empty() ? "" : fmt::format(", except {}", fmt::join(shorter, ", ")), resume_hint(folder));
}

int run(const RunArguments& arguments) {
  outlive_readers();
  const auto host = arguments.scene.plugins.load();
  Progress progress(arguments.output.silent());
  const auto loading = [&](const Loading& now) { progress.load(now.stage, now.share); };
  const Scene scene = arguments.scene.load(*host, loading);
  progress.finish();
  const std::filesystem::path folder = arguments.output.folder_for(arguments.scene.file);
  RunOptions options;
  options.notes = arguments.scene.plugins.notes(*host, scene);
  std::vector<std::string> notes = options.notes;
  for (const std::string& note : notes_of(scene)) notes.push_back(note);
  if (!arguments.output.silent()) {
    std::string text;
    for (const std::string& note : notes) text += fmt::format("note: {}\n", note);
    OutputEstimate estimate = estimate_output(scene);
    if (arguments.trace) {
      estimate.files.push_back({"trace.json", Profiler::trace_bytes(run_trace_events), false});
      estimate.bytes += estimate.files.back().bytes;
    }
    print_report(text + estimate_text(estimate, folder));
  }

  catch_interrupts();
  set_crash_folder(folder);
  options.folder = folder;
  options.profile = arguments.profile;
  options.trace = arguments.trace;
  options.checkpoint = arguments.checkpoint;
  options.resume = arguments.resume;
  options.scene_name = arguments.scene.file.string();
  if (!arguments.realtime.empty()) {
    options.realtime = arguments.realtime == "true" ? 1.0 : std::stod(arguments.realtime);
  }
  options.loading = loading;
  options.progress = [&](const RunProgress& now) { return progress.update(now.time, now.duration); };
  const RunSummary summary = run_scene(scene, host, options);
  progress.finish();

  if (arguments.output.json) {
    fmt::print("{}", to_json(summary));
  } else if (!arguments.output.quiet) {
    print_report(result_text(summary, folder, notes.size()));
    if (summary.profile) print_report(profile_text(*summary.profile, summary.steps));
  }
  std::fflush(stdout);
  if (summary.failure) {
    print_error(fmt::format("{}\n{}", summary.error, kept_text(summary, folder)));
    return status_of(*summary.failure);
  }
  if (summary.outcome == "stopped") {
    print_error(fmt::format("stopped at {:g} s; the output up to then is kept in {}{}", summary.simulated,
                            folder.string(), resume_hint(folder)));
    return failed;
  }
  return done;
}

}  // namespace

void add_run(CLI::App& app, Action& action) {
  const auto arguments = std::make_shared<RunArguments>();
  CLI::App* const command = app.add_subcommand("run", "Simulate a scene and write the results");
  arguments->scene.add_to(*command, true);
  arguments->output.add_to(*command);
  command
      ->add_flag(
          "--realtime", arguments->realtime,
          "Keep pace with the clock, or with a multiple of it: --realtime=0.5 runs at half speed. Each time step "
          "is a frame that starts when it is due; late frames are counted, none is skipped")
      ->type_name("[=FACTOR]")
      ->check(factor_or_true());
  command
      ->add_option(
          "--checkpoint", arguments->checkpoint,
          "Keep a checkpoint in the output folder, from which --resume goes on: the end of the first time step at "
          "or after each multiple of so many simulated seconds")
      ->type_name("S")
      ->check(number_between(above_zero, finite));
  command->add_flag(
      "--resume", arguments->resume,
      "Go on from the last checkpoint in the output folder, after a run that was stopped, killed or ran out of "
      "room: all files but summary.json become those of an undisturbed run with the same --checkpoint");
  command->add_flag("--profile", arguments->profile,
                    "Measure where the time goes: print the share of each stage, law and output, and write all of them "
                    "to profile.json");
  command->add_flag("--trace", arguments->trace,
                    "Write the course of the stages to trace.json, which ui.perfetto.dev and chrome://tracing show: "
                    "of a long run the first and the last time steps");
  command->footer(run_footer());
  command->parse_complete_callback([arguments, command] { refuse_separate_factor(*command, *arguments); });
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace springnet::tool
