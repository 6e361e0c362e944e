#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <system_error>

#define BOOST_DLL_USE_STD_FS
#include <fmt/format.h>
#include <boost/dll/runtime_symbol_info.hpp>
#include <springnet/printable.hpp>
#include <springnet/validation.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "new_files.hpp"
#include "plugin_project.hpp"

namespace springnet::tool {

namespace {

constexpr const char* plugin_new_examples =
    R"text(Writes a project of its own to the folder: NAME.cpp, a CMakeLists.txt that builds it against the installed springnet, a
scene that uses it, a test and a README.md. It builds and passes its test as it is. Existing files are never replaced.

The formula is one as in scenes (formulas.md of the documentation). Its names that are none of the language's become
parameters; comments in the source say what to add: their units, meanings and bounds. The compiled law has the bits of the
formula, and the test compares both. --set gives the value of a parameter in the scene, and its unit: with units those of
the formula are checked. Without it a value is looked for with which the scene runs.

Examples:
  springnet plugin new tendon --kind spring
  springnet plugin new fene --kind spring --formula "stiffness*e/(1 - (e/limit)^2)" --set stiffness="3 N/m" --set limit="0.5 m"
  springnet plugin new honey --kind viscosity --formula "drag*rate*(1 + rate^2)" -o plugins/honey
  springnet plugin new swimmer --kind neuron

Exit status:
  0 done   1 a file cannot be written   2 usage, a formula that cannot be translated, or a file that already exists)text";

struct PluginNewArguments {
  PluginProject project;
  std::string kind;
  std::vector<std::string> sets;
  std::filesystem::path folder;
};

// "limit=0.5 m"
void read_set(const std::string& text, PluginProject& project) {
  const auto refuse = [&text] {
    throw Error(
        ErrorKind::input,
        fmt::format("--set '{}': write NAME=NUMBER or NAME=\"NUMBER UNIT\", as limit=\"0.5 m\"", printable(text)));
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse();
  GivenValue value;
  const char* const begin = text.data() + equals + 1;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(begin, end, value.number);
  if (error != std::errc{} || !std::isfinite(value.number)) refuse();
  if (rest != end && *rest != ' ') refuse();
  value.unit = std::string(std::find_if(rest, end, [](char c) { return c != ' '; }), end);
  if (!project.given.emplace(text.substr(0, equals), value).second)
    throw Error(ErrorKind::input, fmt::format("--set '{}': given twice", printable(text)));
}

ComponentKind project_kind(const std::string& word) {
  if (word == "viscosity") return ComponentKind::viscosity_function;
  if (word == "neuron") return ComponentKind::neuron;
  if (word == "integrator") return ComponentKind::integrator;
  return ComponentKind::spring_function;
}

void check_name(const PluginProject& project) {
  constexpr std::size_t max_length = 100;
  const std::string& name = project.name;
  const auto refuse = [&](std::string_view why) {
    throw Error(ErrorKind::input, fmt::format("the name '{}': {}", printable(name), why));
  };
  const auto is_allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (name.empty() || name[0] < 'a' || name[0] > 'z' || !std::all_of(name.begin(), name.end(), is_allowed))
    refuse("names of components are lower-case letters, digits and '_', a letter first, as 'my_law'");
  if (name.size() > max_length) refuse(fmt::format("it is longer than {} characters", max_length));
  // Targets of CMake that a project has anyway, or that springnet's package takes for its own.
  for (const char* taken :
       {"all", "clean", "depend", "edit_cache", "help", "install", "package", "package_source", "preinstall",
        "rebuild_cache", "springnet", "springnet_internals", "springnet_objects", "test"})
    if (name == taken) refuse("CMake has a target of this name; choose another one");
  const PluginHost host = PluginHost::with_default_search();
  for (const auto& component : host.components())
    if (component->kind() == project.kind && component->id() == name)
      refuse(fmt::format("there is a {} of this name already, in {} {}; choose another one", name_of(project.kind),
                         printable(component->plugin->id), printable_message(component->file.string())));
}

// How well the scene works with a value for all parameters of the law, which mean anything: whether it runs, and as the
// reference does. Empty: well; else what is wrong.
std::string trouble_with(const PluginProject& project) {
  constexpr double tolerance = 0.005;  // half of what the test allows
  try {
    const auto host = std::make_shared<const PluginHost>(PluginHost::with_default_search());
    Scene scene = parse_scene(scene_with_formula(project), project.name, *host);
    scene.options.threads = 1;
    const Validation validation = validate(scene, host);
    const ValidationRun& own = validation.run_of_scene();
    if (!own.finished()) return own.failure;
    if (!validation.within(tolerance)) return "the motion differs from that of the reference";
    return {};
  } catch (const Error& error) {
    return error.what();
  }
}

// Where this springnet is installed; a placeholder if it is not.
std::string prefix() {
  std::error_code unknown;
  const std::filesystem::path root =
      std::filesystem::weakly_canonical(boost::dll::program_location()).parent_path().parent_path();
  const bool installed = std::filesystem::exists(root / SPRINGNET_DATA_FOLDER / "springnet" / "template", unknown);
  return installed ? fmt::format("'{}'", root.string()) : "<where springnet is installed>";
}

int write_project(const PluginNewArguments& arguments) {
  PluginProject project = arguments.project;
  project.kind = project_kind(arguments.kind);
  const bool law = project.kind == ComponentKind::spring_function || project.kind == ComponentKind::viscosity_function;
  if (!law && !project.formula.empty())
    throw Error(ErrorKind::input,
                fmt::format("--formula is for springs and viscosities; leave it out, and write the {} in C++",
                            name_of(project.kind)));
  if (project.formula.empty() && !arguments.sets.empty())
    throw Error(ErrorKind::input, "--set gives values of a formula's parameters: give the formula with --formula");
  for (const std::string& set : arguments.sets) read_set(set, project);
  check_name(project);
  static_cast<void>(files_of(project));  // what is wrong with the formula comes first

  std::string trouble;
  if (!project.formula.empty()) {
    for (const char* value : {"1.0", "0.1", "10.0", "0.01", "100.0"}) {
      project.value = value;
      const std::string now = trouble_with(project);
      if (value == std::string_view("1.0")) trouble = now;
      if (!now.empty()) continue;
      trouble.clear();
      break;
    }
    if (!trouble.empty()) project.value = "1.0";
  }

  const std::filesystem::path folder =
      arguments.folder.empty() ? std::filesystem::path(project.name) : arguments.folder;
  std::vector<Planned> files;
  for (ProjectFile& file : files_of(project)) files.push_back({folder / file.name, {}, std::move(file.text)});
  write_all(folder, files);
  if (!trouble.empty())
    fmt::print("The test will fail until {}.toml has values that suit the law (--set gives them). With {}: {}\n",
               project.name, project.given.empty() ? "all parameters 1" : "these", printable_message(trouble));
  const std::string where = printable_message(folder.string());
  fmt::print(
      "Next:\n"
      "  cmake -S {0} -B {0}/build -DCMAKE_PREFIX_PATH={1}\n"
      "  cmake --build {0}/build\n"
      "  ctest --test-dir {0}/build --output-on-failure\n"
      "  springnet plugin check {0}/build/{2}.springnet.so\n"
      "  springnet run {0}/{2}.toml --plugins {0}/build\n",
      where, printable_message(prefix()), project.name);
  return done;
}

}  // namespace

void add_plugin_new(CLI::App& parent, Action& action) {
  const auto arguments = std::make_shared<PluginNewArguments>();
  CLI::App* const command = parent.add_subcommand("new", "Write a plugin to start from, with a scene and a test");
  command->add_option("NAME", arguments->project.name, "Name of the component in scenes, and of the files")
      ->type_name("")
      ->required();
  command->add_option("--kind", arguments->kind, "What it is: spring, viscosity, neuron or integrator")
      ->type_name("KIND")
      ->required()
      ->check(CLI::IsMember({"spring", "viscosity", "neuron", "integrator"}));
  command->add_option("--formula", arguments->project.formula, "Formula of a spring or viscosity, as in scenes")
      ->type_name("TEXT");
  command
      ->add_option("--set", arguments->sets,
                   "Value of a parameter of the formula in the scene, and its unit. May be repeated")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command->add_option("-o,--output", arguments->folder, "Folder for the files [NAME]")->type_name("DIR");
  command->footer(plugin_new_examples);
  command->callback([arguments, &action] { action = [arguments] { return write_project(*arguments); }; });
}

}  // namespace springnet::tool
