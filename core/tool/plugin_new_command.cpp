#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>
#include <memory>
#include <set>
#include <system_error>

#define BOOST_DLL_USE_STD_FS
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <boost/dll/runtime_symbol_info.hpp>
#include <springnet/formula.hpp>
#include <springnet/printable.hpp>
#include <springnet/scene_formulas.hpp>
#include <springnet/suggestion.hpp>
#include <springnet/validation.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "kind_word.hpp"
#include "new_files.hpp"
#include "plugin_project.hpp"

namespace springnet::tool {

namespace {

constexpr const char* plugin_new_examples =
    R"text(Writes a project of its own to the folder: NAME.cpp, a CMakeLists.txt that builds it against the installed springnet, a
scene that uses it, a test and a README.md. It builds and passes its test as it is. Existing files are never replaced.

The formula is one as in scenes (formulas.md of the documentation). Its names that are none of the language's become
parameters; comments in the source say what to add: their units, meanings and bounds. --set gives the value of a parameter
in the scene, and its unit: with units those of the formula are checked. Without it a value is looked for with which the
scene runs. With --from it is a law of a scene that is a formula, with its parameters, bounds, states, curves, and what
else it declares; --law says which, if there are several. The compiled law has the bits of the formula, and the test
compares both.

Examples:
  springnet plugin new tendon --kind spring
  springnet plugin new fene --kind spring --formula "if(abs(e) < limit, stiffness*e/(1 - (e/limit)^2), nan)" --set stiffness="3 N/m" --set limit="0.5 m"
  springnet plugin new honey --kind viscosity --formula "drag*rate*(1 + rate^2)" -o plugins/honey
  springnet plugin new morse --kind spring --energy "depth*(1 - exp(-width*e))^2" --margin "2 - stretch"
  springnet plugin new dashpot --kind spring --formula "stiffness*(e - z)" --state "z: (e - z)/relaxation"
  springnet plugin new skin --kind spring --scalar "s = area(0, 1, 2)" --energy "k/2*(s - rest(s))^2"
  springnet plugin new tendon --from heart.toml --law body.0.spring
  springnet plugin new swimmer --kind neuron

Exit status:
  0 done   1 a file cannot be written   2 usage, a formula that cannot be translated, or a file that already exists)text";

struct PluginNewArguments {
  PluginProject project;
  std::string kind, formula, energy, margin, law;
  std::vector<std::string> sets, states, inputs, scalars;
  std::filesystem::path scene, folder;

  [[nodiscard]] bool has_formula() const {
    return !formula.empty() || !energy.empty() || !margin.empty() || !states.empty() || !inputs.empty() ||
           !scalars.empty();
  }
};

[[noreturn]] void refuse_new(const std::string& what) { throw Error(ErrorKind::input, what); }

// "limit=0.5 m": a value in the scene and its unit, of one of the law's parameters; of a state, that at the start.
void read_set(const std::string& text, LawFormula& law, ParameterValues& values, std::set<std::string>& given) {
  const auto refuse = [&text](const std::string& why) {
    refuse_new(fmt::format("--set '{}': {}", printable(text), why));
  };
  constexpr const char* form = "write NAME=NUMBER or NAME=\"NUMBER UNIT\", as limit=\"0.5 m\"";
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse(form);
  double value = 0.0;
  const char* const begin = text.data() + equals + 1;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (error != std::errc{} || !std::isfinite(value)) refuse(form);
  if (rest != end && *rest != ' ') refuse(form);
  const std::string name = text.substr(0, equals), unit(std::find_if(rest, end, [](char c) { return c != ' '; }), end);
  if (!given.insert(name).second) refuse("given twice");
  for (FormulaState& state : law.states) {
    if (state.name != name) continue;
    state.start = value;
    state.unit = unit;
    return;
  }
  const auto parameter = std::find_if(law.parameters.begin(), law.parameters.end(),
                                      [&](const FormulaSymbol& each) { return each.name == name; });
  if (parameter == law.parameters.end()) {
    std::vector<std::string> known;
    for (const FormulaSymbol& each : law.parameters) known.push_back(each.name);
    const std::string near = suggestion(name, known);
    refuse(fmt::format("the formula has no parameter '{}'{}{}", printable(name), near.empty() ? "" : "; ", near));
  }
  values[name] = value;
  parameter->unit = unit;
  if (value != 0.0) parameter->scale = std::abs(value);
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

using Clock = std::chrono::steady_clock;

// How well the scene works with a value for all parameters of the law, which mean anything: whether it runs, and as the
// reference does. Empty: well; else what is wrong.
std::string trouble_with(const PluginProject& project, Clock::time_point deadline) {
  constexpr double tolerance = 0.005;  // half of what the test allows
  bool late = false;
  ValidationOptions options;
  options.progress = [&](const ValidationProgress&) { return !(late = Clock::now() > deadline); };
  try {
    const auto host = std::make_shared<const PluginHost>(PluginHost::with_default_search());
    Scene scene = parse_scene(scene_with_formula(project), project.name, *host);
    scene.options.threads = 1;
    const Validation validation = validate(scene, host, options);
    const ValidationRun& own = validation.run_of_scene();
    if (!own.finished()) return own.failure;
    if (!validation.within(tolerance)) return "the motion differs from that of the reference";
    return {};
  } catch (const Error& error) {
    return late ? "the reference takes more than some seconds" : error.what();
  }
}

// A word that a shell takes as it is.
std::string for_shell(const std::string& word) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '/' || c == '.' || c == '_' || c == '-';
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

// Where this springnet is installed; a placeholder if it is not.
std::string prefix() {
  std::error_code unknown;
  const std::filesystem::path root =
      std::filesystem::weakly_canonical(boost::dll::program_location()).parent_path().parent_path();
  const bool installed = std::filesystem::exists(root / SPRINGNET_DATA_FOLDER / "springnet" / "template", unknown);
  return installed ? for_shell(root.string()) : "<where springnet is installed>";
}

// "z: rate" at the first of `between`.
std::pair<std::string, std::string> split(const char* option, const std::string& text, char between, const char* form) {
  const std::size_t at = text.find(between);
  const auto trimmed = [](std::string part) {
    part.erase(0, part.find_first_not_of(' '));
    part.erase(part.find_last_not_of(' ') + 1);
    return part;
  };
  std::pair<std::string, std::string> parts;
  if (at != std::string::npos) parts = {trimmed(text.substr(0, at)), trimmed(text.substr(at + 1))};
  if (parts.first.empty() || parts.second.empty())
    refuse_new(fmt::format("{} '{}': write {}", option, printable(text), form));
  return parts;
}

// The law that options give. States and scalars in the order of their names, which is that of scenes.
LawFormula law_by_options(const PluginNewArguments& arguments, ComponentKind kind) {
  LawFormula law;
  law.kind = kind;
  law.force = arguments.formula;
  law.energy = arguments.energy;
  law.margin = arguments.margin;
  const auto by_name = [](const auto& a, const auto& b) { return a.name < b.name; };
  for (const std::string& each : arguments.states) {
    const auto [name, rate] = split("--state", each, ':', "NAME: RATE, as in --state \"z: (e - z)/relaxation\"");
    law.states.push_back({name, rate});
  }
  for (const std::string& each : arguments.inputs) law.inputs.push_back({each});
  for (const std::string& each : arguments.scalars) {
    const auto [name, of] = split("--scalar", each, '=', "NAME = SCALAR, as in --scalar \"a = length(0, 1)\"");
    law.scalars.push_back({name, of});
  }
  std::sort(law.states.begin(), law.states.end(), by_name);
  std::sort(law.scalars.begin(), law.scalars.end(), by_name);
  law.shape = law.scalars.empty() ? law.shape : shape_of(law.scalars);
  if (!law.scalars.empty() && (law.energy.empty() || !law.force.empty()))
    refuse_new(
        "--scalar: give the --energy of the law alone; forces for several scalars come from a scene, with --from");
  if (law.force.empty() && law.energy.empty()) refuse_new("the law has no formula; give --formula or --energy");
  for (const std::string& name : parameters_of(law)) law.parameters.push_back({name});
  return law;
}

// The law of a scene.
void take_from_scene(const PluginNewArguments& arguments, PluginProject& project) {
  const std::string file = printable_message(arguments.scene.string());
  const PluginHost host = PluginHost::with_default_search();
  const std::vector<SceneFormula> formulas = find_formulas(arguments.scene, host);
  if (formulas.empty()) refuse_new(fmt::format("--from {}: no law of the scene is a formula", file));
  std::vector<std::string> keys;
  for (const SceneFormula& each : formulas) keys.push_back(each.key);
  const std::string wanted = arguments.law.empty() && keys.size() == 1 ? keys[0] : arguments.law;
  const auto found = std::find(keys.begin(), keys.end(), wanted);
  if (found == keys.end()) {
    const std::string nearest = suggestion(wanted, keys);
    refuse_new(fmt::format(
        "--from {}: {}{}{}; '--law KEY' takes one of {}", file,
        wanted.empty() ? "the scene has several formulas" : fmt::format("no formula stands at '{}'", printable(wanted)),
        nearest.empty() ? "" : "; ", nearest, fmt::join(keys, ", ")));
  }
  const SceneFormula& law = formulas[static_cast<std::size_t>(found - keys.begin())];
  project.formula = *formula_of(*law.law.component);
  project.values = law.law.parameters;
  const bool of_springs =
      project.formula->scalars.empty() && law.law.component->law().invariant <= SPRINGNET_RELATIVE_SPEED;
  if (of_springs && law.reference > 0.0) project.rest = law.reference;
  if (!arguments.kind.empty() && kind_of(arguments.kind) != project.formula->kind)
    refuse_new(fmt::format("--kind {}: the formula at '{}' is a {}; leave --kind out", arguments.kind, wanted,
                           name_of(project.formula->kind)));
  project.kind = project.formula->kind;
}

// Values and masses with which the scene runs well. Empty, or what is wrong with the first of them.
std::string find_setting(PluginProject& project, bool from_scene) {
  struct Setting {
    double value, mass, time_step;
  };
  std::vector<Setting> settings;
  if (from_scene)
    settings = {{1.0, 0.01, 0.002},  {1.0, 0.1, 0.002},  {1.0, 1.0, 0.002}, {1.0, 0.01, 0.0002},
                {1.0, 0.001, 0.002}, {1.0, 1.0, 0.0002}, {1.0, 10.0, 0.002}};
  else
    settings = {{1.0, 0.01, 0.002}, {0.1, 0.01, 0.002}, {10.0, 0.01, 0.002}, {0.01, 0.01, 0.002}, {100.0, 0.01, 0.002}};
  const auto set = [&](const Setting& setting) {
    project.value = setting.value;
    project.mass = setting.mass;
    project.time_step = setting.time_step;
  };
  // One law may suit none, and make each take its time.
  constexpr std::chrono::seconds one{3}, all{8};
  const Clock::time_point end = Clock::now() + all;
  std::string trouble;
  for (const Setting& setting : settings) {
    if (Clock::now() > end) break;
    set(setting);
    const std::string now = trouble_with(project, std::min(end, Clock::now() + one));
    if (now.empty()) return {};
    if (trouble.empty()) trouble = now;
  }
  set(settings[0]);
  return trouble;
}

// "stiffness = 3 N/m, limit = 1": those of a formula, so that a typing mistake among them is seen.
std::string parameters_text(const PluginProject& project) {
  std::vector<std::string> texts;
  if (!project.formula) return {};
  for (const FormulaSymbol& each : project.formula->parameters) {
    const auto value = project.values.find(each.name);
    texts.push_back(fmt::format("{} = {:g}{}{}", each.name,
                                value == project.values.end() ? project.value : value->second,
                                each.unit.empty() || each.unit == "1" ? "" : " ", each.unit == "1" ? "" : each.unit));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

int write_project(const PluginNewArguments& arguments) {
  PluginProject project = arguments.project;
  const bool from_scene = !arguments.scene.empty();
  if (arguments.kind.empty() && !from_scene) refuse_new("--kind is required: spring, viscosity, neuron or integrator");
  project.kind = kind_of(arguments.kind);
  if (!is_law(project) && arguments.has_formula())
    refuse_new(fmt::format("--formula is for springs and viscosities; leave it out, and write the {} in C++",
                           name_of(project.kind)));
  if (!arguments.has_formula() && !arguments.sets.empty())
    refuse_new("--set gives values of a formula's parameters: give the formula with --formula");
  if (arguments.has_formula()) {
    LawFormula law = law_by_options(arguments, project.kind);
    std::set<std::string> given;
    for (const std::string& set : arguments.sets) read_set(set, law, project.values, given);
    check_units(law, std::nullopt);  // of names that go with every invariant the scene has springs
    project.formula = std::move(law);
  }
  if (from_scene) take_from_scene(arguments, project);
  check_name(project);
  static_cast<void>(files_of(project));  // what is wrong with the formula comes first

  const std::string trouble = project.formula ? find_setting(project, from_scene) : "";
  const std::filesystem::path folder =
      arguments.folder.empty() ? std::filesystem::path(project.name) : arguments.folder;
  std::vector<Planned> files;
  for (ProjectFile& file : files_of(project)) files.push_back({folder / file.name, {}, std::move(file.text)});
  write_all(folder, files);
  if (const std::string parameters = parameters_text(project); !parameters.empty())
    fmt::print("Parameters: {}\n", parameters);
  if (!trouble.empty())
    fmt::print("The test will fail until {}.toml has values that suit the law{}. {}: {}\n", project.name,
               from_scene ? "" : " (--set gives them)",
               from_scene               ? "With those of the scene"
               : project.values.empty() ? "With all parameters 1"
                                        : "With these",
               printable_message(trouble));
  const std::string where = for_shell(printable_message(folder.string()));
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
  command
      ->add_option("--kind", arguments->kind,
                   "What it is: spring, viscosity, neuron or integrator; with --from that of the law")
      ->type_name("KIND")
      ->check(CLI::IsMember({"spring", "viscosity", "neuron", "integrator"}));
  command->add_option("--formula", arguments->formula, "Formula of a spring or viscosity, as in scenes")
      ->type_name("TEXT");
  const auto add_list = [&](const char* name, std::vector<std::string>& values, const char* help, const char* type) {
    command->add_option(name, values, help)
        ->type_name(type)
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  };
  add_list(
      "--set", arguments->sets,
      "Value of a parameter of the formula in the scene, and its unit; of a state that at the start. May be repeated",
      "NAME=VALUE");
  command->add_option("--energy", arguments->energy, "Its energy, J; without --formula the force is the derivative")
      ->type_name("TEXT");
  command->add_option("--margin", arguments->margin, "What falls from 1 to 0 as it breaks")->type_name("TEXT");
  add_list("--state", arguments->states, "An internal state and its rate, per second. May be repeated", "NAME:RATE");
  add_list("--input", arguments->inputs, "A signal that the formula reads. May be repeated", "NAME");
  add_list("--scalar", arguments->scalars,
           "What an energy reads of a chain, triangle, hinge or tetrahedron: \"a = length(0, 1)\". May be repeated",
           "NAME=SCALAR");
  CLI::Option* const from =
      command->add_option("--from", arguments->scene, "A scene, one of whose formulas becomes the law")
          ->type_name("SCENE");
  command->add_option("--law", arguments->law, "With --from: where the formula stands, as body.0.spring")
      ->type_name("KEY")
      ->needs(from);
  for (const char* option : {"--formula", "--set", "--energy", "--margin", "--state", "--input", "--scalar"})
    command->get_option(option)->excludes(from);
  command->add_option("-o,--output", arguments->folder, "Folder for the files [NAME]")->type_name("DIR");
  command->footer(plugin_new_examples);
  command->callback([arguments, &action] { action = [arguments] { return write_project(*arguments); }; });
}

}  // namespace springnet::tool
