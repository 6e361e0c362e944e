// What a settled step costs, in units that are the same on every machine: naive explicit steps of the same net
// (naive.h), CVODE, one thread. Prints Markdown for core/docs/propagation.md; --json writes what
// tests/benchmark/compare reads.
#include <fnmatch.h>

#include <cstdio>
#include <exception>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/error.hpp>
#include <springnet/mesh.hpp>

#include "measure.hpp"
#include "steps_report.hpp"
#include "table_nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::benchmark;

constexpr const char* usage =
    "usage: springnet_steps_table [OPTION ...]\n"
    "Prints the cost of settled steps in naive explicit steps of the same net, as Markdown.\n"
    "  --json FILE    write the results for tests/benchmark/compare\n"
    "  --only NAME    only the row NAME, or those that a pattern like 'lattice-*' matches; may be repeated\n"
    "  --all          with the rows that take minutes: lattices of 64 nodes a side, stiff ones, fine tissue\n"
    "  --quick        a step or two of each net, once: shows that it runs\n"
    "  --mesh FILE    a mesh of tetrahedra for the block of tissue, a box from the origin\n"
    "  --list         print the names of the rows\n";

struct Arguments {
  std::optional<std::string> json, mesh;
  std::vector<std::string> only;
  bool all = false, quick = false, list = false, help = false;
  std::string text;  // as given, of those that change results
};

struct Row {
  std::string name;
  Kind kind;
  std::string unit;  // "step", "sweep", "scene"
  std::function<Case()> make;
  Window window;
  std::optional<double> floor;
  bool is_slow = false;  // only with --all, or by its name
};

constexpr Window some_steps{.skipped = 2, .steps = 10}, few_steps{.skipped = 1, .steps = 4},
    two_steps{.skipped = 1, .steps = 2};
constexpr Window whole_scene{.steps = all_steps};
constexpr double two_threads = 1.0 / 1.6;  // the time of one that two should not exceed, from 20,000 springs on

std::vector<Row> rows(const Arguments& arguments) {
  const auto lattice = [](std::uint32_t n, double stiffness = 2e4) {
    return [n, stiffness] { return hanging_lattice(n, stiffness); };
  };
  const auto scene = [](const char* name) { return [name] { return example(name); }; };
  const auto block = [mesh = arguments.mesh] { return tissue(mesh ? read_mesh(*mesh) : tissue_mesh()); };
  std::vector<Row> all{
      {"lattice-8", Kind::naive, "step", lattice(8), some_steps, 45.0},
      {"lattice-16", Kind::naive, "step", lattice(16), some_steps, 45.0},
      {"lattice-32", Kind::naive, "step", lattice(32), few_steps, 45.0},
      {"lattice-64", Kind::naive, "step", lattice(64), two_steps, 55.0, true},
      {"tube", Kind::naive, "step", scene("tube"), whole_scene, 78.0},
      {"bladder", Kind::naive, "step", scene("bladder"), whole_scene, 30.0},
      {"sheet", Kind::naive, "step", sheet, {.steps = 20}, 175.0},
      {"cube", Kind::naive, "sweep", scene("cube"), whole_scene, 3.8},
      {"tissue", Kind::naive, "step", block, few_steps, 110.0},
  };
  // The same block by elements of half the length.
  all.push_back(
      {"tissue-fine", Kind::naive, "step", [] { return tissue(tissue_mesh(47)); }, two_steps, std::nullopt, true});
  // t_c^2 k/m; the lattices above have 8.
  for (const std::uint32_t n : {32u, 64u}) {
    for (const double ratio : {10.0, 100.0, 1000.0}) {
      all.push_back({fmt::format("lattice-{}-stiff-{:g}", n, ratio), Kind::naive, "step",
                     lattice(n, ratio / (0.02 * 0.02)), two_steps, std::nullopt, true});
    }
  }
  for (const char* const name : {"cube", "tube", "bladder"}) {
    const double floor = std::string_view(name) == "cube" ? 1.0 : 1.0 / 3.0;
    all.push_back({fmt::format("{}-cvode", name), Kind::reference, "scene", scene(name), whole_scene, floor});
  }
  all.push_back({"lattice-32-threads", Kind::threads, "step", lattice(32), few_steps, two_threads});
  all.push_back({"tissue-threads", Kind::threads, "step", block, few_steps, two_threads});
  return all;
}

Window window_of(const Row& row, bool quick) {
  Window window = row.window;
  if (quick) return {.steps = row.window.steps == all_steps ? 10u : 1u, .least = 0.0, .enough = 0.0, .most = 0.0};
  if (row.kind == Kind::reference) window.most = 5.0;  // CVODE takes some seconds for a scene
  return window;
}

Result measure(const Row& row, bool quick) {
  const Case one = row.make();
  const Window window = window_of(row, quick);
  Result result;
  result.name = row.name;
  result.kind = row.kind;
  result.unit = row.unit;
  result.nodes = one.network.nodes().size();
  result.springs = one.network.springs().size();
  result.elements = one.network.elements().size();
  result.floor = row.floor;

  Cost cost, other;
  if (row.kind == Kind::naive) {
    const Comparison comparison = against_naive(one, window);
    cost = comparison.engine;
    result.other_seconds = comparison.naive;
  } else {
    SimulationOptions options = one.options;
    if (row.kind == Kind::reference) {
      options.integrator = {"cvode", {}};
    } else {
      options.threads = 2;
    }
    const bool is_reference = row.kind == Kind::reference;
    const Pair pair = in_turn(one, one.options, options, window);
    cost = is_reference ? pair.first : pair.second;
    other = is_reference ? pair.second : pair.first;
    result.other_seconds = is_reference ? other.seconds : other.seconds / static_cast<double>(other.steps);
  }
  result.failure = !cost.failure.empty() ? cost.failure : other.failure;
  const auto steps = static_cast<double>(cost.steps);
  const double units = row.unit == "scene" ? 1.0 : row.unit == "sweep" ? static_cast<double>(cost.sweeps) : steps;
  result.seconds = cost.seconds / units;
  result.sweeps = static_cast<double>(cost.sweeps) / steps;
  result.krylov_iterations = cost.krylov_iterations / steps;
  return result;
}

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int k = 1; k < argc; ++k) {
    const std::string_view name = argv[k];
    const auto value = [&] {
      if (k + 1 == argc) throw std::invalid_argument(fmt::format("{} needs a value\n{}", name, usage));
      return std::string(argv[++k]);
    };
    const auto note = [&](const std::string& text) { arguments.text += (arguments.text.empty() ? "" : " ") + text; };
    if (name == "--json") {
      arguments.json = value();
    } else if (name == "--mesh") {
      arguments.mesh = value();
      note("--mesh " + *arguments.mesh);
    } else if (name == "--only") {
      arguments.only.push_back(value());
    } else if (name == "--all") {
      arguments.all = true;
    } else if (name == "--quick") {
      arguments.quick = true;
      note("--quick");
    } else if (name == "--list") {
      arguments.list = true;
    } else if (name == "--help" || name == "-h") {
      arguments.help = true;
    } else {
      throw std::invalid_argument(fmt::format("unknown argument '{}'\n{}", name, usage));
    }
  }
  return arguments;
}

std::vector<Row> chosen(const std::vector<Row>& all, const Arguments& arguments) {
  std::vector<Row> found;
  for (const Row& row : all) {
    bool is_chosen = arguments.only.empty() && (arguments.all || !row.is_slow);
    for (const std::string& pattern : arguments.only) {
      const bool is_named = pattern == row.name, fits = fnmatch(pattern.c_str(), row.name.c_str(), 0) == 0;
      is_chosen = is_chosen || is_named || (fits && (arguments.all || !row.is_slow));
    }
    if (is_chosen) found.push_back(row);
  }
  if (!found.empty()) return found;
  std::vector<std::string> names;
  for (const Row& row : all) names.push_back(row.name);
  throw std::invalid_argument(
      fmt::format("--only '{}' names no row; there are {} (the slow ones by their full names, or with --all)",
                  fmt::join(arguments.only, "', '"), fmt::join(names, ", ")));
}

int run(const Arguments& arguments) {
  const std::vector<Row> selected = chosen(rows(arguments), arguments);
  if (arguments.list) {
    for (const Row& row : selected) fmt::print("{}\n", row.name);
    return 0;
  }
  const Surroundings where = surroundings();
  std::vector<Result> results;
  MarkdownTable table(where);
  bool has_failed = false;
  for (const Row& row : selected) {
    results.push_back(measure(row, arguments.quick));
    table.print(results.back());
    has_failed = has_failed || !results.back().failure.empty();
    // After each row, so that an interrupted run leaves what it has.
    if (arguments.json) write_json(*arguments.json, where, results, arguments.text);
  }
  return has_failed ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Arguments arguments = parse(argc, argv);
    if (arguments.help) {
      fmt::print("{}", usage);
      return 0;
    }
    return run(arguments);
  } catch (const std::invalid_argument& error) {
    fmt::print(stderr, "springnet_steps_table: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "springnet_steps_table: {}\n", error.what());
    return 1;
  }
}
