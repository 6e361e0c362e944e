#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <springnet/learn.hpp>
#include <springnet/printable.hpp>
#include <springnet/scene_writer.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "learn_compare.hpp"
#include "learn_experiments.hpp"
#include "learn_guesses.hpp"
#include "learn_page.hpp"
#include "learn_report.hpp"
#include "process.hpp"
#include "progress.hpp"

namespace springnet::tool {

namespace {

constexpr const char* learn_examples =
    R"(Identifies parameters of a scene from observed motion: the scene runs in the recurrent network, its motion is
differentiated through time, and the values are changed until the sum of the weighted squares of the differences is
least. What the data say of each value is told with it.

FILE is a table (CSV) with a line for each observation: time,node,x,y,z as in trajectory.csv of a run, or vx,vy,vz, or
rx,ry,rz (forces that hold nodes, as in reactions.csv), or time,node,other,distance, or time,x,y,z (points of the
surface); an empty cell is missing, 'weight' or a standard deviation 's' weighs a line.

WHAT is spring.NAME, viscosity.NAME, element.spring.NAME, element.viscosity.NAME, neuron.NAME (parameters that a law
or neuron declares learnable), rest_length, reference, mass, velocity, load, gravity or friction; @BODY takes one body
alone, @BODY/GROUP a group of its nodes, :together one value for all, :field=2 a smooth field of second degree; load@2
is the third [[force]], gravity@z one component, friction@table that of one surface.

Files in the output folder:
  learned.toml      the scene with the values that were learned; many of springs or elements are in
                    learned_springs.csv, learned_elements.csv
  learning.json     each value with its interval, what the data determine, the course of the search
  learning.html     the values on the body, the motions before and after, and curves, for a browser
  learned.fcl       with --correct-rules: the corrected rule base
  learning.state    while the search has not reached its end, what --resume goes on from
Ctrl-C ends the search; the files then have the best values until then.

Examples:
  springnet learn bar.toml --observations seen.csv --parameters spring.stiffness:together,viscosity.damping:together
  springnet learn cube.toml --observations run/trajectory.csv --parameters spring.stiffness,mass@cube -o learned
  springnet learn hung.toml --observations hung.csv --experiment pushed.toml=pushed.csv --parameters spring.stiffness
  springnet learn liver.toml --observations scan.csv --parameters spring.stiffness@liver:field=2

Exit status:
  0 done   1 no value was found, or an error ended the search early; the files then have the best values
  2 usage, scene or observations   3 plugin)";

constexpr const char* widths_rule = "widths";

struct LearnArguments {
  SceneArguments scene;
  OutputArguments output;
  std::vector<std::filesystem::path> observations;
  std::vector<std::string> experiments;
  std::vector<std::string> parameters;
  std::string method = "trajectory";
  double rate = OnlineOptions{}.rate;
  bool compare = false;
  std::string optimiser;
  int iterations = 100;
  double tolerance = LearnOptions{}.tolerance;
  int starts = 1;
  double start_factor = LearnOptions{}.start_factor;
  int certainty_products = LearnOptions{}.certainty_products;
  std::uint64_t seed = LearnOptions{}.seed;
  bool resume = false;
  double memory = 1024.0;  // MiB
  double outlier_distance = Observations{}.outlier_distance;
  double smoothness = LearnOptions{}.smoothness;
  std::string guess_weight = widths_rule;
  double guess_width = 0.0;
  bool correct_rules = false;
  std::vector<std::filesystem::path> held_out;
  std::set<std::string> given;  // options that stand on the command line
};

constexpr const char* online_method = "online";
constexpr const char* learned_file = "learned.toml";
constexpr const char* learning_file = "learning.json";
constexpr const char* page_file = "learning.html";

constexpr const char* state_file = "learning.state";
constexpr const char* rules_file = "learned.fcl";
constexpr const char* learned_stem = "learned";  // of learned_springs.csv, learned_elements.csv

constexpr Optimiser optimisers[] = {Optimiser::levenberg_marquardt, Optimiser::lbfgs, Optimiser::descent};

// Throws Error(input) for options that would have no meaning.
void check(const LearnArguments& arguments) {
  const bool is_online = arguments.method == online_method;
  const auto refuse = [](const std::string& message) { throw Error(ErrorKind::input, message); };
  const auto is_given = [&](const char* name) { return arguments.given.contains(name); };
  for (const char* const of_several_runs : {"--experiment", "--starts", "--start-factor", "--seed", "--resume"}) {
    if (!is_given(of_several_runs)) continue;
    if (is_online)
      refuse(fmt::format("{} is of --method trajectory; 'online' goes through one motion once", of_several_runs));
    if (arguments.compare)
      refuse(
          fmt::format("--compare shows both methods from one start through one motion, from its beginning: leave "
                      "out {}",
                      of_several_runs));
  }
  for (const char* const of_trajectory : {"--optimiser", "--iterations", "--tolerance", "--guess-weight",
                                          "--guess-width", "--correct-rules", "--certainty-products", "--smoothness"})
    if (is_given(of_trajectory) && is_online && !arguments.compare)
      refuse(fmt::format("{} is of --method trajectory; with 'online' it needs --compare", of_trajectory));
  if (is_given("--rate") && !is_online && !arguments.compare)
    refuse("--rate is of --method online; the search for a whole motion finds the length of its steps itself");
  for (const char* const of_starts : {"--start-factor", "--seed"})
    if (is_given(of_starts) && arguments.starts == 1)
      refuse(fmt::format("{} is of searches from several starts; add --starts N", of_starts));
}

// The same of what the tables decide.
void check(const LearnArguments& arguments, const std::vector<Experiment>& experiments) {
  const bool has_places = std::any_of(experiments.begin(), experiments.end(), [](const Experiment& each) {
    const auto has = [](const Observations& seen) { return !seen.surface_points.empty() || !seen.positions.empty(); };
    return has(each.observations) || has(each.held_out);
  });
  if (arguments.given.contains("--outlier-distance") && !has_places)
    throw Error(ErrorKind::input,
                "--outlier-distance is of positions and points of the surface, and the tables have none; leave it out");
}

// Throws Error(input) if there is none.
std::string read_state(const OutputFolder& folder) {
  const std::filesystem::path file = folder.path() / state_file;
  if (folder.kind(state_file) != OutputFolder::Kind::file)
    throw Error(ErrorKind::input, fmt::format("{}: there is none: the search has reached its end, or was stopped "
                                              "before its first iteration; learn without --resume",
                                              file.string()));
  std::ifstream in(file, std::ios::binary);
  std::string state{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw Error(ErrorKind::input, fmt::format("{}: cannot be read", file.string()));
  if (state.empty()) throw Error(ErrorKind::input, fmt::format("{}: is empty; learn without --resume", file.string()));
  return state;
}

// Of values without words as a guess.
void set_guess_widths(std::vector<Learnable>& learnables, double width) {
  using Kind = LearnedValues::Kind;
  for (Learnable& each : learnables) {
    const Kind kind = each.values.kind;
    if (!each.guess_widths.empty() || kind == Kind::initial_velocity || kind == Kind::gravity) continue;
    each.guess_widths.assign(each.values.members.size(), width);
    each.by_logarithm = true;
  }
}

void set_guess_weight(LearnOptions& options, const std::string& text) {
  if (text == widths_rule) {
    options.guess_rule = GuessRule::widths;
  } else if (text == "discrepancy") {
    options.guess_rule = GuessRule::discrepancy;
  } else if (text == "l-curve") {
    options.guess_rule = GuessRule::l_curve;
  } else {
    options.guess_weight = std::strtod(text.c_str(), nullptr);  // checked with the arguments
  }
}

// "iteration  12,  50 % of the time: cost 0.0123, rms 0.045"
std::string text_of(const LearnProgress& now, int starts) {
  const std::string start = starts > 1 ? fmt::format("start {} of {}, ", now.start + 1, starts) : "";
  const std::string guess = now.guess_weight > 0.0 ? fmt::format(", guess weight {:.3g}", now.guess_weight) : "";
  return fmt::format("{}iteration {:3}, {:5.3g} % of the time: cost {:.6g}, rms {:.4g}{}", start, now.iteration,
                     100.0 * now.share, now.cost, now.rms, guess);
}

// Those of an earlier search, which learned.toml may no longer name.
void remove_tables(const OutputFolder::Pointer& folder) {
  for (const std::string& name : folder->names())
    for (const char* const of : {"_springs", "_elements"})
      if (name.starts_with(std::string(learned_stem) + of) && name.ends_with(".csv")) remove_output({folder, name});
}

int run(const LearnArguments& arguments) {
  check(arguments);
  outlive_readers();
  const auto host = arguments.scene.plugins.load();
  Scene scene = arguments.scene.load(*host);
  std::vector<Learnable> learnables = select_learnables(scene.network, *host, arguments.parameters);
  const std::unique_ptr<const GuessedValues> guesses = guesses_of(arguments.scene, host, learnables);
  // The paper's method knows no guess, and both begin alike.
  if (guesses && arguments.method != online_method && !arguments.compare) guesses->set_widths(learnables);
  if (arguments.guess_width > 0.0) set_guess_widths(learnables, arguments.guess_width);
  if (arguments.correct_rules && !guesses)
    throw Error(
        ErrorKind::input,
        "--correct-rules: no value that is learned comes from words of the scene; one from a pipe is read once, "
        "without its words");
  std::vector<Experiment> experiments{experiment_of(scene, arguments.observations)};
  experiments.front().name = arguments.scene.file.string();
  std::vector<Scene> scenes{scene};
  for (const std::string& each : arguments.experiments) {
    SceneExperiment own = experiment_of(each, arguments.scene, *host);
    scenes.push_back(std::move(own.scene));
    experiments.push_back(std::move(own.experiment));
  }
  Experiment& experiment = experiments.front();
  if (!arguments.held_out.empty()) experiment.held_out = observations_of(scene, arguments.held_out);
  for (Experiment& each : experiments) each.observations.outlier_distance = arguments.outlier_distance;
  check(arguments, experiments);
  const OutputFolder::Pointer folder = arguments.output.open_for(
      arguments.scene.file,
      {learned_file, learning_file, page_file, state_file, rules_file, "learned_springs.csv", "learned_elements.csv"});

  catch_interrupts();
  Progress progress(arguments.output.silent());
  LearnOptions options;
  for (const Optimiser each : optimisers)
    if (name_of(each) == arguments.optimiser) options.optimiser = each;
  options.starts = arguments.starts;
  options.start_factor = arguments.start_factor;
  options.certainty_products = arguments.certainty_products;
  options.seed = arguments.seed;
  options.threads = scene.options.threads;
  if (arguments.resume) options.state = read_state(*folder);
  options.on_state = [&](const std::string& state) { write_whole({folder, state_file}, state); };
  options.max_iterations = arguments.iterations;
  options.tolerance = arguments.tolerance;
  options.smoothness = arguments.smoothness;
  options.memory = static_cast<std::size_t>(arguments.memory * (1 << 20));
  set_guess_weight(options, arguments.guess_weight);
  const auto show_iteration = [&](const LearnProgress& now) {
    return progress.search(now.done, text_of(now, arguments.starts));
  };
  const auto show_step = [&](const LearnProgress& now) {
    return progress.update(now.share * scene.duration, scene.duration);
  };
  ToldProgress told;
  options.on_iteration = [&](const LearnProgress& now) {
    if (arguments.compare) told.add(now);
    return show_iteration(now);
  };
  const auto on_step = [&](const LearnProgress& now) {
    if (arguments.compare) told.add(now);
    return show_step(now);
  };
  OnlineOptions online;
  online.rate = arguments.rate;
  online.memory = options.memory;
  const bool is_online = arguments.method == online_method;
  if (is_online) experiment.options.threads = scene.options.threads;
  LearnedNet learned = is_online ? learn_online(experiment, host, learnables, online, on_step)
                                 : learn(experiments, host, learnables, options);
  if (arguments.compare)
    add_courses(learned, arguments.method, told,
                {experiment, host, learnables, options, online, show_iteration, show_step});
  progress.finish();
  std::vector<std::string> notes = arguments.scene.plugins.notes(*host, scene);
  for (const std::string& note : notes_of(scene)) notes.push_back(note);
  learned.notes.insert(learned.notes.begin(), notes.begin(), notes.end());

  if (arguments.correct_rules) {
    const CorrectedRules corrected = corrected_rules(*guesses, learned, arguments.scene);
    learned.notes.insert(learned.notes.end(), corrected.notes.begin(), corrected.notes.end());
    remove_output({folder, rules_file});
    if (!corrected.fcl.empty()) write_whole({folder, rules_file}, corrected.fcl);
  }
  if (!arguments.correct_rules) remove_output({folder, rules_file});
  scene.network = with_values(experiment.network, host, learnables, learned.values);
  const std::string json = to_json(learned);
  write_whole({folder, learning_file}, json);
  const SceneWithTables with_tables = to_scene_with_tables(scene, *host, learned_stem);
  remove_tables(folder);
  for (const SceneTable& each : with_tables.tables) write_whole({folder, each.name}, each.text);
  write_whole({folder, learned_file}, with_tables.scene);  // before the page, whose motions may fail
  std::vector<LearnedMotion> motions;
  for (std::size_t k = 0; k < experiments.size(); ++k) {
    scenes[k].network = with_values(experiments[k].network, host, learnables, learned.values);
    motions.push_back({std::move(scenes[k]), experiments[k]});
  }
  write_learning_page({folder, page_file}, motions, host, learned);
  if (!learned.stopped) remove_output({folder, state_file});
  if (arguments.output.json) {
    fmt::print("{}", json);
  } else if (!arguments.output.quiet) {
    const bool goes_on = learned.stopped && !is_online;
    print_report(fmt::format("{}\n  written: {}, {}, {} in {}\n{}", report_of(learned, learning_file), learned_file,
                             learning_file, page_file, folder->path().string(),
                             goes_on ? "  with --resume the search goes on where it was stopped\n" : ""));
  }
  std::fflush(stdout);
  if (learned.failure.empty()) return done;
  print_error(
      fmt::format("{}; the files in {} have the best values until then", learned.failure, folder->path().string()));
  return failed;
}

}  // namespace

void add_learn(CLI::App& app, Action& action) {
  const auto arguments = std::make_shared<LearnArguments>();
  CLI::App* const command = app.add_subcommand("learn", "Identify parameters of a scene from observed motion");
  arguments->scene.add_to(*command, true);
  command
      ->add_option("--observations", arguments->observations, "Tables of what was observed; SCENE stands before them")
      ->type_name("FILE...")
      ->required();
  command
      ->add_option("--experiment", arguments->experiments,
                   "Another experiment on the same object, with loads and a start of its own, and tables of what was "
                   "observed of it; may be repeated. Options of the scene count for it, too")
      ->type_name("SCENE=FILE,...")
      ->allow_extra_args(false);
  command->add_option("--parameters", arguments->parameters, "What is learned, separated by commas")
      ->type_name("WHAT,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->required();
  command
      ->add_option(
          "--method", arguments->method,
          "trajectory: the whole motion, until the differences are least; online: once through the motion, one "
          "gradient step after each time step, as in the paper [trajectory]")
      ->check(CLI::IsMember({"trajectory", "online"}));
  command
      ->add_option("--optimiser", arguments->optimiser,
                   "levenberg: Gauss-Newton steps with damping (Levenberg, Marquardt); lbfgs: quasi-Newton steps from "
                   "gradients alone, for very many values; descent: the paper's, with momentum [levenberg]")
      ->check(CLI::IsMember({"levenberg", "lbfgs", "descent"}));
  command->add_flag("--compare", arguments->compare,
                    "Learn by the other method, too, from the same start: the page has the cost of the whole motion "
                    "and the values over the work of both");
  command
      ->add_option("--rate", arguments->rate,
                   "Of --method online: how far each gradient step goes, above 0 to 1 [0.05]")
      ->type_name("R")
      ->check(number_between(above_zero, 1.0));
  command
      ->add_option("--iterations", arguments->iterations,
                   "The most iterations over the whole motion, of each start; those before, over its first parts and "
                   "with other weights of the guess, are up to 30 each, and no more than this [100]")
      ->type_name("N")
      ->check(number_between(0, 1e6));
  command
      ->add_option("--tolerance", arguments->tolerance,
                   "A search ends when the cost falls by less than this share of itself in an iteration [1e-10]")
      ->type_name("T")
      ->check(number_between(above_zero, 1.0));
  command
      ->add_option("--starts", arguments->starts,
                   "Searches: the first from the scene's values, others from each value times a factor at random; the "
                   "best is kept, and how far they differ is told [1]")
      ->type_name("N")
      ->check(number_between(1, 1e6));
  command
      ->add_option(
          "--certainty-products", arguments->certainty_products,
          "Of more than 2000 variables: products with the sensitivities, each of about two motions, from which "
          "is told what the data determine [60]")
      ->type_name("N")
      ->check(number_between(1, 1e6));
  command->add_option("--start-factor", arguments->start_factor, "The greatest factor of those starts [3]")
      ->type_name("F")
      ->check(number_between(1.0, finite));
  command->add_option("--seed", arguments->seed, "Of the factors: others with another number [1]")->type_name("N");
  command->add_flag("--resume", arguments->resume,
                    "Go on where a search with the same arguments was stopped or killed, from the output folder: the "
                    "result has the same bits as if it had not been");
  command
      ->add_option(
          "--guess-weight", arguments->guess_weight,
          "Weight of the squares of relative changes from the start, to which values go that the data do not "
          "determine; widths: 1 where words of the scene, or --guess-width, tell how sure it is and the tables "
          "have standard deviations, else 0; discrepancy: the greatest with which differences are within the standard "
          "deviations; l-curve: where smaller ones move values without getting nearer to the observations "
          "[widths]")
      ->type_name("W|widths|discrepancy|l-curve")
      ->check(CLI::IsMember({widths_rule, "discrepancy", "l-curve"}) | number_between(0.0, finite));
  command
      ->add_option(
          "--guess-width", arguments->guess_width,
          "How far off values of the scene may be as guesses, those that words do not tell: the standard "
          "deviation of their logarithm, 0.7 for a factor of 2. Not of start velocities and gravity [not known]")
      ->type_name("S")
      ->check(number_between(above_zero, finite));
  command->add_flag("--correct-rules", arguments->correct_rules,
                    "Write the rule base whose words the scene has with terms that would have guessed what was "
                    "learned, learned.fcl");
  command
      ->add_option("--held-out", arguments->held_out,
                   "Tables of the same motion that are not learned from, but judge what was learned")
      ->type_name("FILE...");
  command
      ->add_option(
          "--memory", arguments->memory,
          "MiB for the states of the motion (what does not fit is simulated again), or for the sensitivities of "
          "--method online [1024]")
      ->type_name("MIB")
      ->check(number_between(above_zero, 1e9));
  command
      ->add_option(
          "--outlier-distance", arguments->outlier_distance,
          "Positions of nodes that are farther off than this, m, and points that are farther from the surface, "
          "count by their distance in place of its square (Huber's function) [none]")
      ->type_name("M")
      ->check(number_between(above_zero, finite));
  command
      ->add_option("--smoothness", arguments->smoothness,
                   "Penalise jumps of the accelerations of nodes from one step to the next: their standard deviation, "
                   "m/s^2 [no penalty]")
      ->type_name("A")
      ->check(number_between(above_zero, finite));
  arguments->output.add_to(*command);
  command->footer(learn_examples);
  command->callback([arguments, command, &action] {
    for (const CLI::Option* const each : command->get_options())
      if (each->count() > 0) arguments->given.insert(each->get_name());
    action = [arguments] { return run(*arguments); };
  });
}

}  // namespace springnet::tool
