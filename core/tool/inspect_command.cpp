#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/inspection.hpp>
#include <springnet/mesh.hpp>
#include <springnet/printable.hpp>
#include <springnet/run.hpp>
#include <springnet/scene_guesses.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "figure_page.hpp"
#include "guess_report.hpp"
#include "inspect_mesh.hpp"
#include "spring_list.hpp"
#include "text/counted.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

constexpr const char* inspect_examples =
    R"(For a scene it reports the largest time step of each installed integrator and of each update rule of the recurrent
network, linearised at the start, with the node and spring that set it; the number of mechanisms (motions that no spring
resists); and likely input mistakes: springs far stiffer than the rest, nodes without springs, parts that nothing fixes,
wrong units. The page inspect.md of the documentation explains the numbers.
Where words of the scene stand for numbers (stiffness = "very soft") it shows which terms and rules gave which number, and
how wide the guess is; --plot draws the membership functions.
--springs writes which spring is where, for tables of values ([[spring]] values).
For a mesh file it reports groups, sizes, edges, the likely unit of its coordinates, and how a scene uses it.

Examples:
  springnet inspect cube/cube.toml              the cube of 'springnet new --example cube'
  springnet inspect cube/cube.toml --set 'body.0.spring.stiffness=20' --json
  springnet inspect cube/cube.toml --set 'body.0.spring.stiffness="soft"' --plot guesses.html
  springnet inspect my_tube/tube.msh            the mesh of 'springnet new --example tube -o my_tube'

Exit status:
  0 done   2 usage or scene   3 plugin)";

struct InspectArguments {
  SceneArguments scene;
  bool json = false;
  std::filesystem::path plot;     // .svg or .html; empty: no picture
  std::filesystem::path springs;  // .csv; empty: no table
};

std::string text_of(const std::optional<Range>& range, const char* unit, bool all_known = true) {
  if (!range) return all_known ? "none" : "unknown";
  if (range->smallest == range->largest) return fmt::format("{:.6g} {}", range->smallest, unit);
  return fmt::format("{:.6g} to {:.6g} {}", range->smallest, range->largest, unit);
}

std::string text_of(const std::map<std::string, std::size_t>& counts) {
  std::string text;
  for (const auto& [id, count] : counts) text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", id, count);
  return text.empty() ? "none" : text;
}

// Two or three digits; whole numbers without a power of ten if possible.
std::string ratio(double value, int digits) {
  return value >= 100.0 && value < 1e6 ? fmt::format("{:.0f}", value) : fmt::format("{:.{}g}", value, digits);
}

std::string text_of(const std::optional<Vibration>& slowest, const Scene& scene) {
  if (!slowest) return "unknown";
  return fmt::format("a period of {:.3g} s, {} time steps; damping ratio {:.2g}", slowest->period,
                     ratio(slowest->period / scene.options.time_step, 3), slowest->damping_ratio);
}

// Of springs, then of elements.
std::string laws_of(const std::map<std::string, std::size_t>& springs,
                    const std::map<std::string, std::size_t>& elements) {
  if (elements.empty()) return text_of(springs);
  return fmt::format("{}{}of elements: {}", springs.empty() ? "" : text_of(springs), springs.empty() ? "" : "; ",
                     text_of(elements));
}

std::vector<std::vector<std::string>> facts(const Scene& scene, const Inspection& found) {
  const Vector3 extent = found.upper - found.lower;
  return {
      {"nodes", fmt::format("{}, {} of them fixed{}; in {}", found.nodes, found.fixed_nodes,
                            found.moved_nodes > 0 ? fmt::format(" ({} moved)", found.moved_nodes) : "",
                            counted(found.bodies, "body", "bodies"))},
      {"neurons", text_of(found.neurons)},
      {"springs",
       fmt::format("{}, of which {} are not at rest length at the start", found.springs, found.springs_under_load)},
      {"elements", text_of(found.elements)},
      {"spring functions", laws_of(found.spring_functions, found.element_spring_functions)},
      {"viscosity functions", laws_of(found.viscosity_functions, found.element_viscosity_functions)},
      {"connected parts",
       fmt::format("{}, nodes without springs: {}", found.parts.size(), found.nodes_without_springs)},
      {"mass of a node", fmt::format("{}; {:.6g} kg in total", text_of(found.mass, "kg"), found.total_mass)},
      {"length", text_of(found.length, "m")},
      {"rest length", text_of(found.rest_length, "m")},
      {"stiffness", text_of(found.stiffness, "N/m at the start", found.unknown_because.empty())},
      {"damping", text_of(found.damping, "N s/m at rest", found.unknown_because.empty())},
      {"extent", fmt::format("{:.6g} x {:.6g} x {:.6g} m from ({:.6g}, {:.6g}, {:.6g})", extent.x(), extent.y(),
                             extent.z(), found.lower.x(), found.lower.y(), found.lower.z())},
      {"changes", fmt::format("loads {}, planes {}, instruments {}, cuts {}", found.loads, found.planes,
                              found.instruments, found.cuts)},
      {"rigid connections", fmt::format("{}{}", found.rigids,
                                        found.mobility.redundant_rigids == 0
                                            ? ""
                                            : fmt::format(", of which {} redundant", found.mobility.redundant_rigids))},
      {"mechanisms", found.mobility.known ? fmt::format("{}, and {}", found.mobility.mechanisms,
                                                        counted(found.mobility.rigid_body_motions,
                                                                "motion as a rigid body", "motions as a rigid body"))
                                          : "not counted, because the network is too large"},
      {"time step", fmt::format("{:g} s, {:.0f} steps in {:g} s", scene.options.time_step,
                                std::ceil(scene.duration / scene.options.time_step * (1.0 - 1e-9)), scene.duration)},
      {"slowest vibration", text_of(found.slowest, scene)},
      {"memory", fmt::format("about {}", readable_bytes(found.memory_bytes))},
      {"output of a run", fmt::format("about {}", readable_bytes(estimate_output(scene).bytes))},
  };
}

std::string text_of(const Network& network, const std::optional<Bottleneck>& set_by) {
  if (!set_by) return "";
  std::string text = fmt::format("node {} ({:.3g} kg)", set_by->node, set_by->mass);
  if (set_by->element) {
    text += fmt::format(", element {} ({}; k {:.3g} N/m", *set_by->element,
                        name_of(network.elements()[*set_by->element].invariant), set_by->stiffness);
  } else if (set_by->spring) {
    const Spring& spring = network.springs()[*set_by->spring];
    text += fmt::format(", spring {} to node {} (k {:.3g} N/m", *set_by->spring,
                        spring.first == set_by->node ? spring.second : spring.first, set_by->stiffness);
  } else {
    return text;
  }
  if (set_by->damping != 0.0) text += fmt::format(", d {:.3g} N s/m", set_by->damping);
  return text + fmt::format("): t^2 k/m {:.2g}, t d/m {:.2g}", set_by->elastic_share, set_by->viscous_share);
}

// Whether an enclosure couples its nodes so strongly that sweeps node by node converge slowly.
bool slowed_by_enclosure(const Scene& scene, const Inspection& found) {
  if (!found.elements.contains(std::string(name_of(Invariant::enclosed_volume)))) return false;
  return std::any_of(found.limits.begin(), found.limits.end(), [&](const TimeConstantLimit& limit) {
    return limit.rule == "synchronous" && limit.time_constant > 0.0 && scene.options.time_step > limit.time_constant;
  });
}

void print_limits(const Scene& scene, const Inspection& found) {
  fmt::print("\nLargest time step of each update rule, linearised at the start{}:\n",
             found.options.theta() == 1.0 ? "" : fmt::format(", theta {:g}", found.options.theta()));
  std::vector<std::vector<std::string>> rows{{"update", "largest time step", "the scene's", "set by"}};
  for (const TimeConstantLimit& limit : found.limits) {
    std::vector<std::string> row{printable(limit.name())};
    switch (limit.kind) {
      case TimeConstantLimit::Kind::none:
        row.insert(row.end(), {"no limit", "", ""});
        break;
      case TimeConstantLimit::Kind::unknown:
        row.insert(row.end(), {"unknown", "", ""});
        break;
      default:
        row.push_back(fmt::format("{}{:.3g} s", limit.kind == TimeConstantLimit::Kind::estimate ? "roughly " : "",
                                  limit.time_constant));
        row.push_back(ratio(scene.options.time_step / limit.time_constant, 2) + " times the limit");
        row.push_back(text_of(scene.network, limit.set_by));
    }
    rows.push_back(row);
  }
  fmt::print("{}", align_columns(rows));
  if (slowed_by_enclosure(scene, found)) {
    fmt::print("  block and coloured have no limit, but need more sweeps the stiffer an enclosed volume is\n");
  }
  if (!found.unknown_because.empty()) fmt::print("  unknown because {}\n", printable_message(found.unknown_because));
  if (found.unique_time_constant) {
    fmt::print("  above {:.3g} s a time step may have several solutions, because springs push or soften (buckling)\n",
               *found.unique_time_constant);
  }
}

// A sentence per finding, then the worst springs.
class Findings {
 public:
  void add(const std::string& text) { text_ += fmt::format("  - {}\n", text); }
  void add(const UnusualSprings& springs, const char* what, const char* unit) {
    if (springs.count == 0) return;
    const std::string bound =
        springs.median > 0.0 ? fmt::format("over {:g} times the median {:.3g}{}", unusual_factor, springs.median, unit)
                             : fmt::format("over {:g}{}", springs.bound, unit);
    add(fmt::format("{}: {} {}; {}:", counted(springs.count, "spring"), what, bound,
                    springs.count > springs.worst.size() ? "the worst are" : "these are"));
    for (const UnusualSpring& spring : springs.worst) {
      text_ += fmt::format("      spring {} (nodes {}, {}): {:.3g}{}\n", spring.spring, spring.first, spring.second,
                           spring.value, unit);
    }
  }
  void print() const {
    fmt::print("\nWorth a look:\n{}", text_.empty() ? std::string("  nothing unusual\n") : printable_message(text_));
  }

 private:
  std::string text_;
};

void add_parts(const Inspection& found, Findings& findings) {
  if (found.nodes_without_springs > 0) {
    std::string numbers;
    for (const NodeIndex node : found.suspicions.nodes_without_springs) {
      numbers += fmt::format("{}{}", numbers.empty() ? "" : ", ", node);
    }
    findings.add(fmt::format("{} without springs: {}{}", counted(found.nodes_without_springs, "node"), numbers,
                             found.nodes_without_springs > listed_at_most ? ", …" : ""));
  }
  if (found.parts.size() < 2) return;
  std::string list;
  for (std::size_t i = 0; i < std::min(found.parts.size(), parts_listed_at_most); ++i) {
    const Part& part = found.parts[i];
    list += fmt::format("\n      {} from node {}{}", counted(part.nodes, "node"), part.first_node,
                        part.fixed_nodes > 0 ? fmt::format(", {} fixed", part.fixed_nodes) : ", none fixed");
  }
  if (found.parts.size() > parts_listed_at_most) list += "\n      …";
  findings.add(fmt::format("{} disconnected parts:{}", found.parts.size(), list));
}

void print_findings(const Network& network, const Inspection& found) {
  const Suspicions& suspicions = found.suspicions;
  Findings findings;
  for (const Hint& hint : found.hints) findings.add(hint.text);
  findings.add(suspicions.stiffness, "stiffness", " N/m");
  findings.add(suspicions.damping, "damping", " N s/m");
  findings.add(suspicions.elastic_rate, "stiffness over mass of the ends", " 1/s^2");
  findings.add(suspicions.viscous_rate, "damping over mass of the ends", " 1/s");
  findings.add(suspicions.strain, "strain at the start", "");
  if (suspicions.springs_without_direction > 0) {
    findings.add(fmt::format("{} with both ends at the same point, where no law can exert a force",
                             counted(suspicions.springs_without_direction, "spring")));
  }
  if (suspicions.springs_that_soften > 0) {
    findings.add(
        fmt::format("{} whose tension decreases with length", counted(suspicions.springs_that_soften, "spring")));
  }
  if (suspicions.lightest) {
    const double light = network.nodes()[*suspicions.lightest].mass, heavy = network.nodes()[*suspicions.heaviest].mass;
    findings.add(fmt::format("masses differ by a factor of {:.3g}: node {} has {:.3g} kg, node {} {:.3g} kg",
                             heavy / light, *suspicions.lightest, light, *suspicions.heaviest, heavy));
  }
  add_parts(found, findings);
  const Mobility& mobility = found.mobility;
  if (mobility.known && mobility.mechanisms > 0) {
    findings.add(fmt::format(
        "{} that no spring resists to first order{}",
        counted(mobility.mechanisms, "motion (mechanism)", "motions (mechanisms)"),
        mobility.springs_under_tension > 0
            ? fmt::format("; the tension of {} may hold them", counted(mobility.springs_under_tension, "spring"))
            : ""));
  }
  if (mobility.redundant_rigids > 0) {
    findings.add(fmt::format("{}: the individual forces are not determined",
                             counted(mobility.redundant_rigids, "redundant rigid connection")));
  }
  findings.print();
}

InspectionOptions options_of(const Scene& scene, const PluginHost& plugins) {
  InspectionOptions options;
  options.time_step = scene.options.time_step;
  options.duration = scene.duration;
  // An integrator with an error tolerance is taken to choose its own time steps.
  const auto integrator = plugins.find(ComponentKind::integrator, scene.options.integrator.id);
  options.adaptive_steps = integrator && parameter_index(*integrator->description, "relative_tolerance") >= 0;
  options.integrator = scene.options.integrator;
  return options;
}

std::vector<SceneGuess> guesses_of(const SceneArguments& arguments, const PluginHost& plugins) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(arguments.file, unknown)) return {};  // a pipe is read once
  std::vector<SceneOverride> overrides;
  for (const std::string& set : arguments.sets) overrides.push_back(parse_override(set));
  return find_guesses(arguments.file, overrides,
                      arguments.allow_outside ? OutsideFiles::allowed : OutsideFiles::refused, &plugins);
}

// Those of guesses say no more than what is shown of them.
std::vector<std::string> notes_without(const std::vector<SceneGuess>& guesses, const Scene& scene) {
  std::vector<std::string> notes = notes_of(scene);
  for (const SceneGuess& guess : guesses) std::erase(notes, note_of(guess));
  return notes;
}

void plot_guesses(const std::vector<SceneGuess>& guesses, const InspectArguments& arguments) {
  if (guesses.empty())
    throw Error(ErrorKind::input, fmt::format("--plot: no words of {} stand for numbers, so there is nothing to draw",
                                              printable_message(arguments.scene.file.string())));
  write_figures(arguments.plot, arguments.scene.file.filename().string(), guess_figures(guesses));
}

// With the guesses in the report of the network.
std::string json_with(const Inspection& found, const std::vector<SceneGuess>& guesses) {
  std::string text = to_json(found);
  if (guesses.empty()) return text;
  auto document = nlohmann::ordered_json::parse(text);
  document["guesses"] = guesses_json(guesses);
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

int run(const InspectArguments& arguments) {
  if (!arguments.plot.empty()) require_ending(arguments.plot);
  if (has_mesh_ending(arguments.scene.file)) {
    if (!arguments.plot.empty())
      throw Error(ErrorKind::input, "'--plot' draws guesses of a scene; a mesh file has none");
    if (!arguments.springs.empty())
      throw Error(ErrorKind::input, "'--springs' lists those of a scene; a mesh file has none");
    if (!arguments.scene.sets.empty()) {
      throw Error(ErrorKind::input, "'--set' changes keys of a scene; a mesh file has none");
    }
    inspect_mesh(arguments.scene.file, arguments.json);
    return done;
  }
  const auto host = arguments.scene.plugins.load();
  const Scene scene = arguments.scene.load(*host);
  const std::vector<SceneGuess> guesses = guesses_of(arguments.scene, *host);
  if (!arguments.plot.empty()) plot_guesses(guesses, arguments);
  if (!arguments.springs.empty()) write_springs(arguments.springs, scene.network);
  const Inspection found = inspect(scene.network, *host, options_of(scene, *host));
  if (arguments.json) {
    fmt::print("{}", json_with(found, guesses));
    return done;
  }
  fmt::print("{}{}{}\n", printable_message(arguments.scene.file.string()), scene.title.empty() ? "" : ": ",
             printable_message(scene.title));
  fmt::print("{}", printable_message(align_columns(facts(scene, found))));
  fmt::print("{}", printable_message(guesses_text(guesses)));
  print_limits(scene, found);
  print_findings(scene.network, found);
  for (const std::string& note : notes_without(guesses, scene)) fmt::print("note: {}\n", printable_message(note));
  for (const std::filesystem::path& written : {arguments.plot, arguments.springs})
    if (!written.empty()) fmt::print("\nwritten: {}\n", printable_message(written.string()));
  return done;
}

}  // namespace

void add_inspect(CLI::App& app, Action& action) {
  const auto arguments = std::make_shared<InspectArguments>();
  CLI::App* const command = app.add_subcommand("inspect", "Describe a scene's network, or a mesh");
  arguments->scene.add_to(*command, false);
  command->get_option("SCENE")->description("Scene file (TOML) or mesh file");
  command->add_flag("--json", arguments->json, "Print JSON");
  command
      ->add_option("--plot", arguments->plot,
                   "Draw the guesses that words of the scene stand for: FILE.svg or FILE.html")
      ->type_name("FILE");
  command
      ->add_option("--springs", arguments->springs,
                   "Write a row for each spring: its number, its ends, where its middle is, and its rest length")
      ->type_name("FILE.csv");
  command->footer(inspect_examples);
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace springnet::tool
