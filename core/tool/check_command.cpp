#include <algorithm>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/scene.hpp>

#include "check/check.hpp"
#include "commands.hpp"
#include "common.hpp"
#include "kind_word.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* check_examples =
    R"(Examples:
  springnet plugin check build/tendon.springnet.so       all components of a file
  springnet plugin check heart.toml                      all laws of a scene, formulas among them
  springnet plugin check muscle                          a component that is installed
  springnet plugin check muscle --only derivatives --seed 7

Every check runs in a process of its own: a law that crashes, hangs or ends the process is a line of the report.
--only runs what the check needs as well, and tells of that what fails. --seed is for the elements of laws and neurons;
integrators are always tried on the same nets.
Checks of laws, in this order: load call arrays finite rest energy derivatives dissipation batches states promises order
leaks speed. Of neurons: load call arrays finite derivatives batches leaks. Of integrators: load call order momentum
states events contact rigid refusals options repeats memory leaks.

Exit status:
  0 all passed, perhaps with warnings   1 a check failed   2 usage   3 the plugin cannot be loaded)";

struct CheckArguments {
  PluginArguments plugins;
  std::string target, kind, only;
  std::uint64_t seed = 0;  // 0: a new one
  double seconds = check::Limits{}.seconds;
  bool json = false;
};

check::Target target_of(const CheckArguments& arguments) {
  using What = check::Target::What;
  const std::filesystem::path path(arguments.target);
  std::error_code unreadable;
  check::Target target{What::component, arguments.target, {}};
  if (!arguments.kind.empty()) target.kind = kind_of(arguments.kind);
  const bool is_file = std::filesystem::is_regular_file(path, unreadable) || path.has_parent_path() ||
                       path.stem().extension() == ".springnet";
  if (is_file) target.what = What::file;
  if (path.extension() == ".toml") {
    target.what = What::scene;
    target.read = [](const std::filesystem::path& scene, const PluginHost& host) {
      return load_scene(scene, host).network;
    };
  }
  return target;
}

Json json_of(const check::Report& report) {
  Json checks = Json::array();
  for (const check::Finding& finding : report.findings)
    checks.push_back({{"component", finding.component},
                      {"kind", finding.kind},
                      {"check", finding.check},
                      {"result", check::name_of(finding.outcome.result)},
                      {"why", finding.outcome.why}});
  return {{"seed", report.seed}, {"loaded", report.loaded}, {"passed", report.passed()}, {"checks", checks}};
}

std::string table_of(const check::Report& report) {
  std::vector<std::vector<std::string>> rows{{"COMPONENT", "CHECK", "RESULT", ""}};
  std::string before;
  for (const check::Finding& finding : report.findings) {
    const std::string name = fmt::format("{} ({})", finding.component, finding.kind);
    rows.push_back(
        {name == before ? "" : name, finding.check, check::name_of(finding.outcome.result), finding.outcome.why});
    before = name;
  }
  const auto count = [&](auto is) {
    return std::count_if(report.findings.begin(), report.findings.end(),
                         [&](const check::Finding& finding) { return is(finding.outcome.result); });
  };
  const auto bad = count([](check::Result result) { return check::is_bad(result); });
  const auto warnings = count([](check::Result result) { return result == check::Result::warned; });
  return fmt::format("{}\n{} checks: {} failed, {} warnings; seed {}\n", align_columns(rows, 0), report.findings.size(),
                     bad, warnings, report.seed);
}

int run_check(const CheckArguments& arguments) {
  check::Options options;
  options.seed = arguments.seed != 0 ? arguments.seed : std::random_device{}() % 1'000'000 + 1;
  options.only = arguments.only;
  options.limits.seconds = arguments.seconds;
  options.folders = arguments.plugins.folders;
  const check::Report report = check::check_target(target_of(arguments), options);
  if (arguments.json) {
    fmt::print("{}\n", json_of(report).dump(2, ' ', false, Json::error_handler_t::replace));
  } else {
    print_report(table_of(report));
  }
  if (!report.loaded) return plugin_trouble;
  return report.passed() ? done : failed;
}

}  // namespace

void add_plugin_check(CLI::App& parent, Action& action) {
  const auto arguments = std::make_shared<CheckArguments>();
  CLI::App* const command =
      parent.add_subcommand("check", "Test a plugin, or the laws of a scene: do they do what they declare?");
  command->add_option("TARGET", arguments->target, "A plugin's file, a scene, or a component's name")
      ->type_name("")
      ->required();
  command
      ->add_option("--kind", arguments->kind,
                   "Of components by name only this kind: spring, viscosity, neuron or integrator")
      ->type_name("KIND")
      ->check(CLI::IsMember({"spring", "viscosity", "neuron", "integrator"}));
  std::vector<std::string> names;
  for (const std::string_view name : check::check_names()) names.emplace_back(name);
  command->add_option("--only", arguments->only, "Only this check")->type_name("CHECK")->check(CLI::IsMember(names));
  command
      ->add_option(
          "--seed", arguments->seed,
          "Draw the same random elements as a report with this seed [a new one each time]; not for integrators")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  command->add_option("--time-limit", arguments->seconds, "Longest time for a check, in seconds [20]")
      ->type_name("S")
      ->check(number_between(0.1, 3600.0));
  arguments->plugins.add_to(*command);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->footer(check_examples);
  command->callback([arguments, &action] { action = [arguments] { return run_check(*arguments); }; });
}

}  // namespace springnet::tool
