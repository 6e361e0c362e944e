#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <springnet/validation.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "process.hpp"
#include "progress.hpp"

namespace springnet::tool {

namespace {

constexpr const char* validate_examples =
    R"(The scene runs in its own integrator (usually the recurrent network) with several time steps, and in the reference
CVODE, which is certified by a second run with a lower tolerance. The positions of all nodes are compared at common
times, in metres and as a share of the reference's greatest displacement from the start. The paper's network is a method
of first order: half the time step, half the error. One more run, with theta = 0.5, shows whether second order is better.

Files in the output folder:
  validation.json   all numbers
  report.html       table and plots in one file, for a browser

Examples (the cube is that of 'springnet new --example cube'):
  springnet validate cube/cube.toml
  springnet validate cube/cube.toml --time-steps 0.1,0.05,0.01 --tolerance 0.02

Exit status:
  0 done   1 the reference or the run with the scene's time step failed, or that run exceeds the tolerance
  2 usage or scene   3 plugin)";

struct ValidateArguments {
  SceneArguments scene;
  OutputArguments output;
  std::vector<double> time_steps;
  double tolerance = 0.0;             // m
  double reference_tolerance = 1e-8;  // relative
};

constexpr const char* validation_file = "validation.json";
constexpr const char* report_file = "report.html";

int run(const ValidateArguments& arguments) {
  outlive_readers();
  const auto host = arguments.scene.plugins.load();
  const Scene scene = arguments.scene.load(*host);
  const OutputFolder::Pointer folder = arguments.output.open_for(arguments.scene.file, {validation_file, report_file});

  catch_interrupts();
  Progress progress(arguments.output.silent());
  ValidationOptions options;
  options.time_steps = arguments.time_steps;
  options.relative_tolerance = arguments.reference_tolerance;
  options.certifying_tolerance = arguments.reference_tolerance / 100.0;
  options.scene_name = arguments.scene.file.string();
  options.progress = [&](const ValidationProgress& now) { return progress.update(now.time, now.duration); };
  Validation validation = validate(scene, host, options);
  progress.finish();
  std::vector<std::string> notes = arguments.scene.plugins.notes(*host, scene, "cvode");
  for (const std::string& note : notes_of(scene)) notes.push_back(note);
  validation.notes.insert(validation.notes.begin(), notes.begin(), notes.end());

  const std::string json = to_json(validation);
  write_whole({folder, validation_file}, json);
  write_whole({folder, report_file}, to_html(validation));
  if (arguments.output.json) {
    fmt::print("{}", json);
  } else if (!arguments.output.quiet) {
    print_report(fmt::format("{}\n  written: {}, {} in {}\n", to_table(validation), validation_file, report_file,
                             folder->path().string()));
  }
  std::fflush(stdout);

  // Nothing is validated if that run did not reach the end.
  const ValidationRun& own = validation.run_of_scene();
  const bool wanted = arguments.tolerance > 0.0;
  if (!own.finished()) {
    print_error(fmt::format("the run with the scene's time step of {:g} s failed: {}", own.time_step, own.failure));
    return status_of(own.failure_kind);
  }
  if (!wanted || validation.within(arguments.tolerance)) return done;
  print_error(fmt::format(
      "with the scene's time step of {:g} s the error is up to {:.3g} m, plus {:.2g} m of uncertainty of the "
      "reference, which exceeds the tolerance of {:g} m. Try a smaller time step{}",
      own.time_step, own.error.max, validation.uncertainty(), arguments.tolerance,
      validation.second_order_is_better() ? ", or theta = 0.5" : ""));
  return failed;
}

}  // namespace

void add_validate(CLI::App& app, Action& action) {
  const auto arguments = std::make_shared<ValidateArguments>();
  CLI::App* const command = app.add_subcommand("validate", "Compare a scene's time steps with a reference integrator");
  arguments->scene.add_to(*command, true);
  command
      ->add_option("--time-steps", arguments->time_steps,
                   "Time steps in seconds, in addition to the scene's own [half and a quarter of it]")
      ->type_name("A,B,C")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(number_between(above_zero, finite));
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "Exit with status 1 unless every error with the scene's own time step is within M metres")
      ->type_name("M")
      ->check(number_between(above_zero, finite));
  command
      ->add_option("--reference-tolerance", arguments->reference_tolerance,
                   "Relative tolerance of the reference; the run that certifies it uses a hundredth of it [1e-08]")
      ->type_name("R")
      ->check(number_between(1e-11, 1e-3));
  arguments->output.add_to(*command);
  command->footer(validate_examples);
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace springnet::tool
