#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>

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
#include "process.hpp"
#include "progress.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

constexpr const char* learn_examples =
    R"(Identifies parameters of a scene from observed motion: the scene runs in the recurrent network, its motion is
differentiated through time, and the values are changed until the sum of the weighted squares of the differences is
least. What the data say of each value is told with it.

FILE is a table (CSV) with a line for each observation: time,node,x,y,z as in trajectory.csv of a run, or vx,vy,vz, or
rx,ry,rz (forces that hold nodes, as in reactions.csv), or time,node,other,distance, or time,x,y,z (points of the
surface); an empty cell is missing, 'weight' or a standard deviation 's' weighs a line.

WHAT is spring.NAME, viscosity.NAME, element.spring.NAME, element.viscosity.NAME, neuron.NAME (parameters that a law or
neuron declares learnable), rest_length, reference, mass, velocity, load or gravity; @BODY takes one body alone,
@BODY/GROUP a group of its nodes, :together one value for all, :field=2 a smooth field of second degree; load@2 is the
third [[force]], gravity@z one component.

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
  0 done   1 no value was found   2 usage, scene or observations   3 plugin)";

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
  int starts = 1;
  double start_factor = LearnOptions{}.start_factor;
  int certainty_products = LearnOptions{}.certainty_products;
  std::uint64_t seed = LearnOptions{}.seed;
  bool resume = false;
  double memory = 1024.0;  // MiB
  double outlier_distance = Observations{}.outlier_distance;
  std::string guess_weight = widths_rule;
  bool correct_rules = false;
  std::vector<std::filesystem::path> held_out;
};

constexpr const char* learned_file = "learned.toml";
constexpr const char* learning_file = "learning.json";
constexpr const char* page_file = "learning.html";

constexpr const char* state_file = "learning.state";
constexpr const char* rules_file = "learned.fcl";
constexpr const char* learned_stem = "learned";  // of learned_springs.csv, learned_elements.csv

constexpr Optimiser optimisers[] = {Optimiser::levenberg_marquardt, Optimiser::lbfgs, Optimiser::descent};

void check(const LearnArguments& arguments) {
  const bool is_online = arguments.method == "online";
  const std::pair<const char*, bool> of_several_runs[] = {{"--experiment", !arguments.experiments.empty()},
                                                          {"--starts", arguments.starts > 1},
                                                          {"--resume", arguments.resume}};
  for (const auto& [name, is_given] : of_several_runs) {
    if (is_given && is_online)
      throw Error(ErrorKind::input,
                  fmt::format("{} is of --method trajectory; 'online' goes through one motion once", name));
    if (is_given && arguments.compare)
      throw Error(ErrorKind::input, fmt::format("--compare shows both methods from one start through one motion, from "
                                                "its beginning: leave out {}",
                                                name));
  }
  if (is_online && !arguments.compare && !arguments.optimiser.empty())
    throw Error(ErrorKind::input, "--optimiser is of --method trajectory; with 'online' it needs --compare");
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

// With the width alone where the ends do not differ in the digits that are shown.
std::string interval_of(const LearnedParameter& each) {
  const std::string lower = fmt::format("{:.6g}", each.lower), upper = fmt::format("{:.6g}", each.upper);
  if (lower != upper) return lower + " to " + upper;
  return fmt::format("{} ± {:.1g}", lower, 0.5 * (each.upper - each.lower));
}

// One row for each variable; two for a field, where it is least and greatest.
std::string table_of(const LearnedNet& learned) {
  constexpr std::size_t most = 12;
  std::vector<std::vector<std::string>> rows{{"VALUE", "START", "LEARNED", "95 % INTERVAL", "HALF THE TIME STEP ADDS"}};
  std::size_t variable = 0, left_out = 0;
  const auto add = [&](const LearnedParameter& each, const char* which) {
    if (rows.size() > most) {
      ++left_out;
      return;
    }
    std::string interval = std::isfinite(each.determined) ? "not determined" : "not known";
    if (std::isfinite(each.upper)) interval = interval_of(each);
    if (each.at_bound) interval += ", at its bound";
    rows.push_back({value_title(each) + which, fmt::format("{:.6g}", each.start), fmt::format("{:.8g}", each.value),
                    interval,
                    std::isfinite(each.by_time_step) ? fmt::format("{:+.2g}", each.by_time_step) : "not known"});
  };
  for (const LearnedParameter& each : learned.parameters) {
    if (each.variable != variable) continue;  // of one that stands there already
    variable += each.variables;
    if (each.variables == 1) {
      add(each, "");
      continue;
    }
    const LearnedParameter *least = &each, *greatest = &each;
    for (const LearnedParameter& other : learned.parameters) {
      if (other.variable != each.variable) continue;
      if (other.value < least->value) least = &other;
      if (other.value > greatest->value) greatest = &other;
    }
    add(*least, ", least of the field");
    add(*greatest, ", greatest of the field");
  }
  std::string text = align_columns(rows);
  if (left_out > 0) text += fmt::format("  and {} more, in {}\n", left_out, learning_file);
  return text;
}

std::string report_of(const LearnedNet& learned) {
  std::string text = fmt::format(
      "{} variables from {} observed values\n  cost {:.6g} at first, {:.6g} at the end, rms of the "
      "weighted differences {:.4g}, {} iterations\n  {}\n\n{}",
      learned.variables, learned.observed, learned.start_cost, learned.cost, learned.rms,
      learned.history.empty() ? 0 : learned.history.back().iteration, learned.reason, table_of(learned));
  if (learned.undetermined > 0) {
    text += fmt::format(
        "\n  {} combinations of the variables have no influence on what was observed. Values that they "
        "touch are not determined; they stay near their start.\n",
        learned.undetermined);
  }
  if (!learned.guess_curve.empty())
    text += fmt::format("\n  weight of the guess: {:.4g}, from {} tried\n", learned.guess_weight,
                        learned.guess_curve.size());
  if (learned.held_out.observed > 0) {
    text += fmt::format("\n  held out: {} values, rms of their weighted differences {:.4g} at first, {:.4g} at the end",
                        learned.held_out.observed, learned.held_out.start_rms, learned.held_out.rms);
    if (std::isfinite(learned.held_out.half_step_rms))
      text += fmt::format(", about {:.4g} with half the time step", learned.held_out.half_step_rms);
    text += "\n";
  }
  if (!learned.courses.empty()) text += comparison_table(learned.courses);
  for (const std::string& note : learned.notes) text += fmt::format("  note: {}\n", note);
  return text;
}

// "iteration  12,  50 % of the time: cost 0.0123, rms 0.045"
std::string text_of(const LearnProgress& now, int starts) {
  const std::string start = starts > 1 ? fmt::format("start {} of {}, ", now.start + 1, starts) : "";
  return fmt::format("{}iteration {:3}, {:5.3g} % of the time: cost {:.6g}, rms {:.4g}", start, now.iteration,
                     100.0 * now.share, now.cost, now.rms);
}

int run(const LearnArguments& arguments) {
  check(arguments);
  outlive_readers();
  const auto host = arguments.scene.plugins.load();
  Scene scene = arguments.scene.load(*host);
  std::vector<Learnable> learnables;
  for (const std::string& each : arguments.parameters)
    learnables.push_back(select_learnable(scene.network, *host, each));
  const std::unique_ptr<const GuessedValues> guesses = guesses_of(arguments.scene, host, learnables);
  if (guesses) guesses->set_widths(learnables);
  if (arguments.correct_rules && !guesses)
    throw Error(ErrorKind::input, "--correct-rules: no value that is learned comes from words of the scene");
  std::vector<Experiment> experiments{experiment_of(scene, arguments.observations)};
  std::vector<Scene> scenes{scene};
  for (const std::string& each : arguments.experiments) {
    SceneExperiment own = experiment_of(each, arguments.scene, *host);
    scenes.push_back(std::move(own.scene));
    experiments.push_back(std::move(own.experiment));
  }
  Experiment& experiment = experiments.front();
  if (!arguments.held_out.empty()) experiment.held_out = observations_of(scene, arguments.held_out);
  for (Experiment& each : experiments) each.observations.outlier_distance = arguments.outlier_distance;
  const OutputFolder::Pointer folder =
      arguments.output.open_for(arguments.scene.file, {learned_file, learning_file, page_file, state_file, rules_file});

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
  if (arguments.method == "online") experiment.options.threads = scene.options.threads;
  LearnedNet learned = arguments.method == "online" ? learn_online(experiment, host, learnables, online, on_step)
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
    write_whole({folder, rules_file}, corrected.fcl);
  }
  scene.network = with_values(experiment.network, host, learnables, learned.values);
  const std::string json = to_json(learned);
  write_whole({folder, learning_file}, json);
  std::vector<LearnedMotion> motions;
  for (std::size_t k = 0; k < experiments.size(); ++k) {
    scenes[k].network = with_values(experiments[k].network, host, learnables, learned.values);
    motions.push_back({std::move(scenes[k]), experiments[k]});
  }
  write_learning_page({folder, page_file}, motions, host, learned);
  const SceneWithTables with_tables = to_scene_with_tables(scene, *host, learned_stem);
  for (const SceneTable& each : with_tables.tables) write_whole({folder, each.name}, each.text);
  write_whole({folder, learned_file}, with_tables.scene);
  if (!learned.stopped) remove_output({folder, state_file});
  if (arguments.output.json) {
    fmt::print("{}", json);
  } else if (!arguments.output.quiet) {
    print_report(fmt::format("{}\n  written: {}, {}, {} in {}\n{}", report_of(learned), learned_file, learning_file,
                             page_file, folder->path().string(),
                             learned.stopped ? "  with --resume the search goes on where it was stopped\n" : ""));
  }
  std::fflush(stdout);
  return done;
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
  command->add_option("--iterations", arguments->iterations, "The most iterations of the search [100]")
      ->type_name("N")
      ->check(number_between(0, 1e6));
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
      ->add_option("--guess-weight", arguments->guess_weight,
                   "Weight of the squares of relative changes from the start, to which values go that the data do not "
                   "determine; widths: 1 where words of the scene are the guess and the tables have standard "
                   "deviations, else 0; discrepancy: the greatest with which differences are within the standard "
                   "deviations; l-curve: where smaller ones move values without getting nearer to the observations "
                   "[widths]")
      ->type_name("W|widths|discrepancy|l-curve")
      ->check(CLI::IsMember({widths_rule, "discrepancy", "l-curve"}) | number_between(0.0, finite));
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
      ->add_option("--outlier-distance", arguments->outlier_distance,
                   "Points that are farther from the surface, m, count by their distance in place of its square [none]")
      ->type_name("M")
      ->check(number_between(above_zero, finite));
  arguments->output.add_to(*command);
  command->footer(learn_examples);
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace springnet::tool
