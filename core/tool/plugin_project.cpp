#include "plugin_project.hpp"

#include <cctype>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <springnet/formula.hpp>
#include <springnet/formula_source.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

namespace springnet::tool {

namespace {

constexpr std::string_view neuron_source = R"(#include <springnet/sdk/neuron.hpp>

namespace {{
using namespace springnet::sdk;

struct {type} : Neuron {{
  static constexpr const char *id = "{name}", *summary = "mass point in a viscous medium, a = (F - drag v) / m";
  static constexpr Parameter parameters[] = {{number("drag", "kg/s", "force of the medium per speed").at_least(0)}};

  // It has to depend on the force as F / m.
  static auto acceleration(const auto& n, const auto& p) {{ return (n.force - p[0] * n.velocity) / n.mass; }}
}};
}}  // namespace

SPRINGNET_PLUGIN("org.example.{name}", "0.1.0", "your name", "MIT", {type});
)";

constexpr std::string_view integrator_source = R"(#include <limits>

#include <springnet/sdk/integrator.hpp>

namespace {{
using namespace springnet::sdk;

// Symplectic Euler: v' = v + h a(p, v), p' = p + h v'.
class {type} : public Integrator {{
 public:
  static constexpr const char *id = "{name}", *summary = "symplectic Euler";

  {type}(Host host, Options) : host_(host), next_(host.make_state()) {{}}

  springnet_status advance(double until, springnet_step_report& report) {{
    const double start = host_.committed().time, h = until - start;
    host_.begin_step(start, until);  // loads are averaged over the step
    const springnet_state& now = host_.committed().state;
    auto sweep = sized<springnet_sweep>();
    sweep.time = until;
    sweep.time_constant = h;
    sweep.start_position = sweep.position = view(now.position);
    sweep.start_velocity = sweep.velocity = view(now.velocity);
    sweep.next_position = next_->position;
    sweep.next_velocity = next_->velocity;
    sweep.force = next_->force;
    // Called for each tile of nodes, from several threads.
    host_.sweep(sweep, [&](const springnet_node_batch& batch) {{
      const auto move = [&](const double* a, const double* v, const double* p, double* next_v, double* next_p) {{
        for (std::uint32_t i = 0; i < batch.count; ++i) {{
          const std::uint32_t k = batch.first + i;
          next_v[k] = v[k] + h * a[i];
          next_p[k] = p[k] + h * next_v[k];
        }}
      }};
      move(batch.acceleration.x, now.velocity.x, now.position.x, next_->velocity.x, next_->position.x);
      move(batch.acceleration.y, now.velocity.y, now.position.y, next_->velocity.y, next_->position.y);
      move(batch.acceleration.z, now.velocity.z, now.position.z, next_->velocity.z, next_->position.z);
    }});
    host_.commit(until, *next_);
    report.outcome = SPRINGNET_SETTLED;
    report.steps = report.sweeps = 1;
    report.residual = std::numeric_limits<double>::quiet_NaN();  // not evaluated
    return SPRINGNET_OK;
  }}

 private:
  Host host_;
  State next_;
}};
}}  // namespace

SPRINGNET_PLUGIN("org.example.{name}", "0.1.0", "your name", "MIT", {type});
)";

constexpr std::string_view cmake_text =
    R"(# cmake -S . -B build -DCMAKE_PREFIX_PATH=<where springnet is installed> && cmake --build build
# ctest --test-dir build --output-on-failure
cmake_minimum_required(VERSION 3.25)
project({name} LANGUAGES CXX)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release)
endif()

find_package(springnet REQUIRED COMPONENTS sdk)
springnet_add_plugin({name} SOURCES {name}.cpp)

enable_testing()
add_test(NAME {name}_test COMMAND ${{CMAKE_COMMAND}} -DTOOL=${{springnet_TOOL}} -DPLUGINS=$<TARGET_FILE_DIR:{name}>
  -DOUTPUT=${{CMAKE_CURRENT_BINARY_DIR}}/test -P ${{CMAKE_CURRENT_SOURCE_DIR}}/test.cmake)
)";

constexpr std::string_view test_start = R"(# The test of the plugin, run by ctest:
#   cmake -DTOOL=<springnet> -DPLUGINS=<folder of the plugin> -DOUTPUT=<folder for results> -P test.cmake
cmake_minimum_required(VERSION 3.25)
set(scene ${{CMAKE_CURRENT_LIST_DIR}}/{name}.toml)

# springnet(ARGUMENT ...): fails if the tool does.
function(springnet)
  execute_process(COMMAND ${{TOOL}} ${{ARGN}} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# It loads.
springnet(plugin show {name} --kind {kind} --plugins ${{PLUGINS}})

# It keeps the rules of its kind, if this springnet checks them.
execute_process(COMMAND ${{TOOL}} plugin check --help OUTPUT_VARIABLE help ERROR_QUIET)
if(help MATCHES "plugin check")
  {check} {checked} --plugins ${{PLUGINS}}{ending})
endif()

# Its motion is that of the reference.
springnet(validate ${{scene}} --plugins ${{PLUGINS}} --tolerance 0.01 --output ${{OUTPUT}}/validation)
)";

// Another component has the same bits, {with} in place of type = "…".
constexpr std::string_view test_same = R"(
# It has the bits of {what}. Remove this once it is to be another law.
file(READ ${{scene}} own)
set(other [==[{with}]==])
string(REPLACE "type = \"{name}\"" "${{other}}" other "${{own}}")
if(other STREQUAL own)
  message(FATAL_ERROR "${{scene}} does not use {name}")
endif()
file(WRITE ${{OUTPUT}}/other.toml "${{other}}")
springnet(run ${{scene}} --plugins ${{PLUGINS}} --quiet --output ${{OUTPUT}}/own)
springnet(run ${{OUTPUT}}/other.toml --quiet --output ${{OUTPUT}}/other)
execute_process(COMMAND ${{CMAKE_COMMAND}} -E compare_files ${{OUTPUT}}/own/trajectory.csv ${{OUTPUT}}/other/trajectory.csv
  RESULT_VARIABLE different)
if(different)
  message(FATAL_ERROR "{name} has not the bits of {what}: trajectory.csv differs in ${{OUTPUT}}/own and ${{OUTPUT}}/other")
endif()
)";

constexpr std::string_view scene_text =
    R"(# Two masses hang one below the other and come to rest. scene.md of the documentation describes every key.
#   springnet run {name}.toml --plugins build
title = "{title}"

[simulation]
duration   = 2.0    # s
time_step  = 0.002  # s
integrator = {integrator}

[output]
interval = 0.02  # s between records

[gravity]
acceleration = [0, 0, -9.81]  # m/s^2

[[body]]
name      = "chain"
nodes     = [[0, 0, 0], [0, 0, -1], [0, 0.1, -2]]  # m
springs   = [[0, 1], [1, 2]]
neuron    = {neuron}
spring    = {spring}
viscosity = {viscosity}

[[fix]]
select = {{ nodes = [0] }}
)";

constexpr std::string_view readme_text = R"(# {name}

A {kind} for springnet, `{name}.cpp`, built outside of springnet's sources.

```sh
cmake -S . -B build -DCMAKE_PREFIX_PATH=<where springnet is installed>
cmake --build build
ctest --test-dir build --output-on-failure
springnet plugin check build/{name}.springnet.so
springnet run {name}.toml --plugins build        # results/{name}/view.html plays the motion
springnet validate {name}.toml --plugins build   # how far it is from the reference, CVODE
springnet plugin show {name} --plugins build{plot}
```

`cmake --install build --prefix <where springnet is installed>` puts the plugin where springnet finds it without `--plugins`.

| file | |
|---|---|
| `{name}.cpp` | the {kind} |
| `{name}.toml` | a scene that uses it |
| `test.cmake` | the test: {tests} |

{next} The author's guide is `share/doc/springnet/sdk.md` of the installation.
)";

std::string_view kind_word(ComponentKind kind) {
  switch (kind) {
    case ComponentKind::spring_function:
      return "spring";
    case ComponentKind::viscosity_function:
      return "viscosity";
    case ComponentKind::neuron:
      return "neuron";
    case ComponentKind::integrator:
      return "integrator";
  }
  return "";
}

bool is_law(const PluginProject& project) {
  return project.kind == ComponentKind::spring_function || project.kind == ComponentKind::viscosity_function;
}

// Without comments, in one line: characters of the language alone, which no text has to escape.
std::string in_one_line(std::string_view formula) {
  std::string line;
  bool comment = false;
  for (const char c : formula) {
    comment = c != '\n' && (comment || c == '#');
    if (comment) continue;
    const bool space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (!space)
      line += c;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  while (line.ends_with(' ')) line.pop_back();
  return line;
}

// `springnet plugin list` has a line for it.
std::string summary_of(std::string_view formula) {
  constexpr std::size_t longest = 60;
  std::string line = in_one_line(formula);
  if (line.size() > longest) line = line.substr(0, longest) + "...";
  return line;
}

// Without --formula.
struct FirstLaw {
  const char *formula, *unit, *summary;
};
FirstLaw first_law(const PluginProject& project) {
  if (project.kind == ComponentKind::spring_function) return {"stiffness*e", "N/m", "tension per elongation"};
  return {"damping*rate", "N s/m", "tension per rate"};
}

LawFormula formula_of(const PluginProject& project) {
  LawFormula law;
  law.kind = project.kind;
  law.force = project.formula.empty() ? first_law(project).formula : project.formula;
  return law;
}

// "my_law" is MyLaw, "fene" FeneLaw: the SDK has classes of one word.
std::string type_of(const PluginProject& project) {
  const std::string suffix = is_law(project) ? "Law" : project.kind == ComponentKind::neuron ? "Neuron" : "Method";
  std::string type;
  bool starts = true;
  for (const char c : project.name) {
    if (c != '_') type += starts ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    starts = c == '_';
  }
  return type.ends_with(suffix) && type != suffix ? type : type + suffix;
}

constexpr std::size_t line_length = 120;

// number("stiffness", "N/m", "").learnable(3)
std::string described(const PluginProject& project, const std::string& name) {
  const FirstLaw first = first_law(project);
  if (project.formula.empty())
    return fmt::format("number(\"{}\", \"{}\", \"{}\").at_least(0)", name, first.unit, first.summary);
  const auto given = project.given.find(name);
  if (given == project.given.end()) return fmt::format("number(\"{}\", \"1\", \"\")", name);
  const auto& [number, unit] = given->second;
  const std::string typical = number == 0.0 ? "" : fmt::format(".learnable({})", std::abs(number));
  return fmt::format("number(\"{}\", \"{}\", \"\"){}", name, unit.empty() ? "1" : unit, typical);
}

// "units, meanings and bounds": what is left to be written.
std::string left_to_say(const PluginProject& project, const FormulaSource& source) {
  for (const std::string& name : source.parameters)
    if (!project.given.contains(name) || project.given.at(name).unit.empty()) return "units, meanings and bounds";
  return "meanings and bounds";
}

std::string parameters_text(const PluginProject& project, const FormulaSource& source) {
  if (source.parameters.empty()) return "";
  const std::string start = "  static constexpr Parameter parameters[] = {";
  std::vector<std::string> entries;
  std::size_t length = start.size() + 2;
  for (const std::string& name : source.parameters) {
    entries.push_back(described(project, name));
    length += entries.back().size() + 2;
  }
  const std::string next = length <= line_length ? ", " : ",\n" + std::string(start.size(), ' ');
  const std::string to_do = project.formula.empty()
                                ? ""
                                : fmt::format("  // TODO: {}, as number(\"mass\", \"kg\", \"of the bob\").above(0).\n",
                                              left_to_say(project, source));
  return fmt::format("{}{}{}}};\n", to_do, start, fmt::join(entries, next));
}

std::string force_text(const FormulaSource& source) {
  std::string text = fmt::format("  static auto force(const auto&{}, const auto&{}) {{",
                                 source.uses_element ? " e" : "", source.uses_parameters ? " p" : "");
  if (source.statements.size() == 1 && text.size() + source.statements[0].size() + 3 <= line_length)
    return fmt::format("{} {} }}\n", text, source.statements[0]);
  for (const std::string& statement : source.statements) text += "\n    " + statement;
  return text + "\n  }\n";
}

std::string law_source(const PluginProject& project) {
  const FormulaSource source = source_of(formula_of(project));
  const std::string type = type_of(project);
  std::string text = fmt::format(
      "#include <springnet/sdk/law.hpp>\n\nnamespace {{\nusing namespace springnet::sdk;\n\nstruct {} : {} {{\n", type,
      project.kind == ComponentKind::spring_function ? "SpringFunction" : "ViscosityFunction");
  if (!source.enumerators.empty()) text += fmt::format("  enum {{ {} }};\n", fmt::join(source.enumerators, ", "));
  text += fmt::format("  static constexpr const char *id = \"{}\", *summary = \"{}\";\n", project.name,
                      summary_of(formula_of(project).force));
  for (const std::string& declaration : source.declarations) text += "  " + declaration + "\n";
  text += parameters_text(project, source) + "\n" + force_text(source);
  return text + fmt::format(
                    "}};\n}}  // namespace\nSPRINGNET_PLUGIN(\"org.example.{}\", \"0.1.0\", \"your name\", "
                    "\"MIT\", {});\n",
                    project.name, type);
}

// As a scene has it.
std::string value_of(const PluginProject& project, const std::string& parameter) {
  const auto given = project.given.find(parameter);
  if (given == project.given.end()) return project.value;
  const std::string text = fmt::format("{}", given->second.number);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

// { type = "…", stiffness = 1.0 }
std::string use_of(const PluginProject& project, const std::string& type) {
  std::string text = "{ " + type;
  if (is_law(project))
    for (const std::string& name : source_of(formula_of(project)).parameters)
      text += fmt::format(", {} = {}", name, value_of(project, name));
  return text + " }";
}

// "  # N/m, m", or nothing.
std::string units_of(const PluginProject& project) {
  std::string text;
  for (const std::string& name : source_of(formula_of(project)).parameters) {
    const auto given = project.given.find(name);
    if (given == project.given.end() || given->second.unit.empty()) return "";
    text += (text.empty() ? "  # " : ", ") + given->second.unit;
  }
  return text;
}

std::string scene_of(const PluginProject& project, const std::string& type) {
  std::string neuron = "{ type = \"point_mass\", mass = 0.01 }  # kg";
  std::string spring = "{ type = \"linear\", stiffness = 1.0 }  # N/m";
  std::string viscosity = "{ type = \"linear\", damping = 0.02 }  # N s/m";
  std::string integrator = "{ name = \"recurrent\", theta = 0.5 }";
  switch (project.kind) {
    case ComponentKind::spring_function:
      spring = use_of(project, type) + units_of(project);
      break;
    case ComponentKind::viscosity_function:
      viscosity = use_of(project, type) + units_of(project);
      break;
    case ComponentKind::neuron:
      neuron = "{ " + type + ", mass = 0.01, drag = 0.005 }  # kg, kg/s";
      break;
    case ComponentKind::integrator:
      integrator = "{ " + type + " }";
      break;
  }
  return fmt::format(scene_text, fmt::arg("name", project.name),
                     fmt::arg("title", fmt::format("Two masses with the {} {}", kind_word(project.kind), project.name)),
                     fmt::arg("integrator", integrator), fmt::arg("neuron", neuron), fmt::arg("spring", spring),
                     fmt::arg("viscosity", viscosity));
}

std::string formula_in_scene(const PluginProject& project) {
  return fmt::format("formula = \"{}\"", in_one_line(formula_of(project).force));
}

std::string test_of(const PluginProject& project) {
  std::string text =
      fmt::format(test_start, fmt::arg("name", project.name), fmt::arg("kind", kind_word(project.kind)),
                  // Of a formula whose parameters have no bounds yet the report does not count.
                  fmt::arg("check", project.formula.empty()
                                        ? "springnet(plugin check"
                                        : "# TODO: springnet(plugin check …), which may fail, once parameters have "
                                          "bounds.\n  execute_process(COMMAND ${TOOL} plugin check"),
                  fmt::arg("ending", project.formula.empty() ? "" : " COMMAND_ECHO STDOUT"),
                  // A law with the parameters of the scene, because a formula may hold for few others.
                  fmt::arg("checked", is_law(project) ? "${scene}" : project.name.c_str()));
  const bool neuron = project.kind == ComponentKind::neuron;
  if (project.kind == ComponentKind::integrator) return text;
  return text + fmt::format(test_same, fmt::arg("name", project.name),
                            fmt::arg("what", neuron ? "springnet's own neuron 'dragged'" : "its formula in a scene"),
                            fmt::arg("with", neuron ? "type = \"dragged\"" : formula_in_scene(project)));
}

std::string readme_of(const PluginProject& project) {
  const char* tests = "it loads, and moves as the reference";
  const char* next = "Change the method in `advance`.";
  if (is_law(project)) {
    tests = "it loads, moves as the reference, and has the bits of its formula";
    next =
        project.formula.empty()
            ? "Change the formula in `force`, its parameters, their values in the scene, and the formula in the test."
            : "Give the parameters what the source says (TODO), and the scene values that suit the law.";
  } else if (project.kind == ComponentKind::neuron) {
    tests = "it loads, moves as the reference, and has the bits of springnet's own neuron `dragged`";
    next = "Change the formula in `acceleration`, and what the test compares it with.";
  }
  return fmt::format(
      readme_text, fmt::arg("name", project.name), fmt::arg("kind", name_of(project.kind)), fmt::arg("tests", tests),
      fmt::arg("next", next),
      fmt::arg("plot", is_law(project) ? fmt::format(" --plot {}.html   # its curves", project.name) : ""));
}

// Throws Error(input) for values of what the formula does not read, and units that do not fit.
void check_given(const PluginProject& project) {
  LawFormula law = formula_of(project);
  ParameterValues values;
  for (const std::string& name : parameters_of(law)) {
    const auto given = project.given.find(name);
    law.parameters.push_back({name, given == project.given.end() ? "" : given->second.unit});
    values[name] = 1.0;
  }
  for (const auto& [name, value] : project.given) {
    if (values.contains(name)) continue;
    std::vector<std::string> known;
    for (const FormulaSymbol& each : law.parameters) known.push_back(each.name);
    const std::string near = suggestion(name, known);
    throw Error(ErrorKind::input, fmt::format("--set: the formula has no parameter '{}'{}{}", printable(name),
                                              near.empty() ? "" : "; ", near));
  }
  static_cast<void>(law_of(law, values));
}

}  // namespace

std::string scene_with_formula(const PluginProject& project) { return scene_of(project, formula_in_scene(project)); }

std::vector<ProjectFile> files_of(const PluginProject& project) {
  if (!project.given.empty()) check_given(project);
  const bool integrator = project.kind == ComponentKind::integrator;
  const std::string own = fmt::format("{} = \"{}\"", integrator ? "name" : "type", project.name);
  const std::string type = type_of(project);
  const std::string source = is_law(project) ? law_source(project)
                                             : fmt::format(fmt::runtime(integrator ? integrator_source : neuron_source),
                                                           fmt::arg("name", project.name), fmt::arg("type", type));
  return {{project.name + ".cpp", source},
          {project.name + ".toml", scene_of(project, own)},
          {"CMakeLists.txt", fmt::format(cmake_text, fmt::arg("name", project.name))},
          {"test.cmake", test_of(project)},
          {"README.md", readme_of(project)}};
}

}  // namespace springnet::tool
