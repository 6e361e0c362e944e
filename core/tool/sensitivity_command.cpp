#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/printable.hpp>
#include <springnet/sensitivities.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "process.hpp"
#include "progress.hpp"
#include "run/record_times.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

constexpr const char* sensitivity_examples =
    R"(Differentiates the motion of a scene by values of its network while it goes on: in cvode, by CVODES, the derivatives
are held to the tolerances of the motion. They say how much a stiffness or a mass matters, where, and when.

WHAT is spring.NAME, viscosity.NAME, element.spring.NAME, element.viscosity.NAME, neuron.NAME (parameters that a law or
neuron declares learnable), rest_length, reference, mass or velocity; @BODY takes one body alone, :together one
derivative for all of them.

File in the output folder:
  sensitivity.csv   time,parameter,member,node,dx,dy,dz,dvx,dvy,dvz: derivatives of a node's position and velocity
                    by the value of a spring, element or node; of the scene's nodes and at the times of its output

Motions with contact, ruptures or cuts, rigid connections and laws with internal states are refused.

Examples:
  springnet sensitivity bar.toml --parameters spring.stiffness:together,mass
  springnet sensitivity bar.toml --parameters rest_length --set simulation.integrator.relative_tolerance=1e-10

Exit status:
  0 done   1 the motion failed, or cannot be differentiated   2 usage or scene   3 plugin)";

constexpr const char* table_file = "sensitivity.csv";
constexpr const char* reference = "cvode";

struct SensitivityArguments {
  SceneArguments scene;
  OutputArguments output;
  std::vector<std::string> parameters;
};

// How far a column moves a node if its value changes by one per cent (0: by 0.01 of its unit).
struct Greatest {
  double change = 0.0;  // m
  double time = 0.0;    // s
  NodeIndex node = 0;
};

void take(const ReferenceSensitivities& motion, std::vector<Greatest>& greatest) {
  for (std::size_t j = 0; j < greatest.size(); ++j) {
    const double value = motion.columns()[j].value;
    const double change = 0.01 * (value != 0.0 ? std::abs(value) : 1.0);
    Eigen::Index node = 0;
    const double distance = change * motion.position_changes(j).colwise().norm().maxCoeff(&node);
    if (distance > greatest[j].change) greatest[j] = {distance, motion.time(), static_cast<NodeIndex>(node)};
  }
}

std::string member_of(const SensitivityColumn& column) {
  if (column.values > 1) return fmt::format("{} together", column.values);
  return fmt::format("{}", column.member);
}

std::string table_of(const std::vector<SensitivityColumn>& columns, const std::vector<Greatest>& greatest) {
  constexpr std::size_t most = 12;
  std::vector<std::vector<std::string>> rows{{"PARAMETER", "OF", "VALUE", "1 % OF IT MOVES A NODE BY UP TO"}};
  for (std::size_t j = 0; j < std::min(most, columns.size()); ++j)
    rows.push_back({columns[j].name, member_of(columns[j]), fmt::format("{:.6g}", columns[j].value),
                    greatest[j].change > 0.0 ? fmt::format("{:.3g} m, node {} at {:.4g} s", greatest[j].change,
                                                           greatest[j].node, greatest[j].time)
                                             : "0 m"});
  std::string text = align_columns(rows);
  if (columns.size() > most) text += fmt::format("  and {} more, in {}\n", columns.size() - most, table_file);
  return text;
}

std::string json_of(const std::vector<SensitivityColumn>& columns, const std::vector<Greatest>& greatest, double until,
                    std::size_t records) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t j = 0; j < columns.size(); ++j)
    list.push_back({{"parameter", columns[j].name},
                    {"member", columns[j].member},
                    {"values", columns[j].values},
                    {"value", columns[j].value},
                    {"one_per_cent_moves_m", greatest[j].change},
                    {"node", greatest[j].node},
                    {"time", greatest[j].time}});
  const nlohmann::ordered_json all{{"file", table_file}, {"simulated", until}, {"records", records}, {"columns", list}};
  return all.dump(2) + "\n";
}

int run(const SensitivityArguments& arguments) {
  outlive_readers();
  const auto host = arguments.scene.plugins.load();
  SceneArguments of_reference = arguments.scene;
  if (!of_reference.integrator) of_reference.integrator = reference;
  const Scene scene = of_reference.load(*host);
  const std::vector<Learnable> of = select_learnables(scene.network, *host, arguments.parameters);
  ReferenceSensitivities motion(std::make_shared<const Network>(scene.network), host, scene.options, of);
  const OutputFolder::Pointer folder = arguments.output.open_for(arguments.scene.file, {table_file});

  catch_interrupts();
  Progress progress(arguments.output.silent());
  SensitivityTable table({folder, table_file}, scene.output.nodes);
  std::vector<Greatest> greatest(motion.columns().size());
  std::size_t records = 0;
  const double interval = record_interval(scene), slack = time_slack(scene.options.time_step, scene.duration);
  for (;;) {
    table.record(motion);
    take(motion, greatest);
    ++records;
    if (motion.time() >= scene.duration - slack || !progress.update(motion.time(), scene.duration)) break;
    motion.advance_to(std::min(next_multiple(interval, motion.time(), slack), scene.duration));
  }
  progress.finish();
  table.close();

  if (arguments.output.json) {
    fmt::print("{}", json_of(motion.columns(), greatest, motion.time(), records));
  } else if (!arguments.output.quiet) {
    std::string text = fmt::format("{} derivatives of {} records, until {:g} s\n\n{}\n", motion.columns().size(),
                                   records, motion.time(), table_of(motion.columns(), greatest));
    std::vector<std::string> notes = arguments.scene.plugins.notes(*host, scene);
    for (const std::string& note : notes_of(scene)) notes.push_back(note);
    for (const std::string& note : notes) text += fmt::format("  note: {}\n", note);
    print_report(fmt::format("{}  written: {} in {}\n", text, table_file, folder->path().string()));
  }
  std::fflush(stdout);
  return done;
}

}  // namespace

void add_sensitivity(CLI::App& app, Action& action) {
  const auto arguments = std::make_shared<SensitivityArguments>();
  CLI::App* const command = app.add_subcommand("sensitivity", "Differentiate the motion of a scene by its parameters");
  arguments->scene.add_to(*command, true);
  command->add_option("--parameters", arguments->parameters, "What it is differentiated by, separated by commas")
      ->type_name("WHAT,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->required();
  arguments->output.add_to(*command);
  command->footer(sensitivity_examples);
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace springnet::tool
