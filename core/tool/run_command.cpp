#include <cmath>
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "commands.hpp"
#include "common.hpp"
#include "progress.hpp"

namespace springnet::tool {

namespace {

constexpr const char* examples = R"(Files (in the folder of the output):
  trajectory.csv   time,node,x,y,z,vx,vy,vz   s, m, m/s; the scene's [output] says how often
  reactions.csv    time,node,fx,fy,fz,tx,…    N, N m: what holds nodes, if output.reactions = true
  surfaces.csv     time,surface,x,y,z,fx,…    forces and torques on planes and instruments
  rigid.csv        time,rigid,force           N: tension of rigid connections
  events.csv       time,event,element,index   cuts, ruptures, contacts
  summary.json     how the run went

Examples:
  springnet run examples/cube/cube.toml
  springnet run cube.toml --time-step 0.01 --duration 5 -o /tmp/cube
  springnet run cube.toml --integrator cvode --set simulation.integrator.method=\"adams\"
  springnet run cube.toml --set output.interval=0.5 --set output.reactions=true

Exit status:
  0 done   1 the simulation failed (what it wrote until then is kept)   2 usage or scene   3 plugin)";

struct RunArguments {
  SceneArguments scene;
  OutputArguments output;
};

// Notes from number `first` on; those before stood on the terminal before the run.
void print_result(const RunSummary& summary, const std::filesystem::path& folder, std::size_t first) {
  const auto steps = static_cast<double>(summary.steps);
  fmt::print("{}: {}, {} nodes, {} springs\n", summary.scene, summary.integrator.id, summary.nodes, summary.springs);
  fmt::print("  outcome    {}\n", summary.outcome);
  fmt::print(
      "  simulated  {:g} s of {:g} s in {:.3g} s: {} steps, {:.1f} sweeps a step, {:.3g} million springs a second\n",
      summary.simulated, summary.duration, summary.wall, summary.steps,
      steps > 0.0 ? static_cast<double>(summary.sweeps) / steps : 0.0,
      summary.wall > 0.0 ? summary.spring_updates / summary.wall / 1e6 : 0.0);
  if (summary.unsettled > 0) {
    fmt::print("  warning    {} of {} time steps were accepted without having settled\n", summary.unsettled,
               summary.steps);
  }
  if (summary.divided > 0) {
    fmt::print("  substeps   {} of {} time steps were divided, {} smaller steps in all\n", summary.divided,
               summary.steps, summary.substeps);
  }
  if (summary.stages > 0) {
    fmt::print("  stages     {} smaller time constants on the way to the full one\n", summary.stages);
  }
  if (std::isfinite(summary.largest_residual)) fmt::print("  residual   {:.2g} N at most\n", summary.largest_residual);
  fmt::print("  events     {}\n", describe(summary.events));
  fmt::print("  written    {} ({} and the summary) in {}\n", fmt::join(summary.files, ", "),
             readable_bytes(static_cast<double>(summary.bytes)), folder.string());
  for (std::size_t k = first; k < summary.notes.size(); ++k) fmt::print("  note       {}\n", summary.notes[k]);
}

int run(const RunArguments& arguments) {
  const auto host = arguments.scene.plugins.load();
  const Scene scene = arguments.scene.load(*host);
  const std::filesystem::path folder = arguments.output.folder_for(arguments.scene.file);
  RunOptions options;
  options.notes = arguments.scene.plugins.notes(*host);
  std::vector<std::string> notes = options.notes;
  for (const std::string& note : notes_of(scene)) notes.push_back(note);
  if (!arguments.output.silent()) {
    for (const std::string& note : notes) fmt::print("note: {}\n", note);
    const OutputEstimate estimate = estimate_output(scene);
    fmt::print("writing about {} ({:.0f} records) to {}\n", readable_bytes(estimate.bytes), estimate.records,
               folder.string());
    std::fflush(stdout);
  }

  catch_interrupts();
  Progress progress(arguments.output.silent());
  options.folder = folder;
  options.scene_name = arguments.scene.file.string();
  options.progress = [&](const RunProgress& now) {
    progress.update(now.time, now.duration);
    return !interrupted();
  };
  const RunSummary summary = run_scene(scene, host, options);
  progress.finish();

  if (arguments.output.json) {
    fmt::print("{}", to_json(summary));
  } else if (!arguments.output.quiet) {
    print_result(summary, folder, notes.size());
  }
  std::fflush(stdout);
  if (summary.failure) {
    print_error(fmt::format("{}\nWhat was written until {:g} s is kept in {}.", summary.error, summary.simulated,
                            folder.string()));
    return status_of(*summary.failure);
  }
  if (summary.outcome == "stopped") {
    print_error(fmt::format("stopped at {:g} s; what was written until then is kept in {}", summary.simulated,
                            folder.string()));
    return failed;
  }
  return done;
}

}  // namespace

void add_run(CLI::App& app, Action& action) {
  const auto arguments = std::make_shared<RunArguments>();
  CLI::App* const command = app.add_subcommand("run", "Simulate a scene and write its course");
  arguments->scene.add_to(*command, true);
  arguments->output.add_to(*command);
  command->footer(examples);
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace springnet::tool
