#include "plugin_project.hpp"

#include <cctype>
#include <string_view>

#include <fmt/format.h>

#include "kind_word.hpp"

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
{curves}if(other STREQUAL own)
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

constexpr std::string_view readme_text = R"(# {name}

A {kind} for springnet, `{name}.cpp`, built outside of springnet's sources.

```sh
cmake -S . -B build -DCMAKE_PREFIX_PATH=<where springnet is installed>
cmake --build build
ctest --test-dir build --output-on-failure
springnet plugin show {name} --plugins build
springnet run {name}.toml --plugins build
```

`cmake --install build --prefix <where springnet is installed>` puts the plugin where springnet finds it without `--plugins`.

| file | |
|---|---|
| `{name}.cpp` | the {kind} |
| `{name}.toml` | a scene that uses it |
| `test.cmake` | the test: {tests} |

{next} The author's guide is `share/doc/springnet/sdk.md` of the installation.
)";

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

std::string test_of(const PluginProject& project) {
  const bool own = !project.formula;
  std::string text =
      fmt::format(test_start, fmt::arg("name", project.name), fmt::arg("kind", kind_word(project.kind)),
                  // Of a formula whose parameters have no bounds yet the report does not count.
                  fmt::arg("check", own ? "springnet(plugin check"
                                        : "# TODO: springnet(plugin check …), which may fail, once parameters have "
                                          "bounds.\n  execute_process(COMMAND ${TOOL} plugin check"),
                  fmt::arg("ending", own ? "" : " COMMAND_ECHO STDOUT"),
                  // A law with the parameters of the scene, because a formula may hold for few others.
                  fmt::arg("checked", is_law(project) ? "${scene}" : project.name.c_str()));
  if (project.kind == ComponentKind::integrator) return text;
  const bool neuron = project.kind == ComponentKind::neuron;
  const LawInScene plugin = plugin_in_scene(project);
  const LawInScene other = neuron ? LawInScene{"type = \"dragged\"", ""} : formula_in_scene(project);
  const std::string curves =
      plugin.tables.empty()
          ? ""
          : fmt::format("string(REPLACE [==[{}]==] [==[{}]==] other \"${{other}}\")\n", plugin.tables, other.tables);
  return text + fmt::format(test_same, fmt::arg("name", project.name),
                            fmt::arg("what", neuron ? "springnet's own neuron 'dragged'" : "its formula in a scene"),
                            fmt::arg("with", other.type), fmt::arg("curves", curves));
}

std::string readme_of(const PluginProject& project) {
  const char* tests = "it loads, and moves as the reference";
  const char* next = "Change the method in `advance`.";
  if (is_law(project)) {
    tests = "it loads, moves as the reference, and has the bits of its formula";
    next =
        !project.formula
            ? "Change the formula in `force`, its parameters, their values in the scene, and the formula in the test."
            : "Give the parameters units, meanings and bounds (TODO), and the scene values that suit the law.";
  } else if (project.kind == ComponentKind::neuron) {
    tests = "it loads, moves as the reference, and has the bits of springnet's own neuron `dragged`";
    next = "Change the formula in `acceleration`, and what the test compares it with.";
  }
  return fmt::format(readme_text, fmt::arg("name", project.name), fmt::arg("kind", name_of(project.kind)),
                     fmt::arg("tests", tests), fmt::arg("next", next));
}

}  // namespace

bool is_law(const PluginProject& project) {
  return project.kind == ComponentKind::spring_function || project.kind == ComponentKind::viscosity_function;
}

LawFormula law_of(const PluginProject& project) {
  if (project.formula) return *project.formula;
  LawFormula law;
  law.kind = project.kind;
  const bool is_spring = project.kind == ComponentKind::spring_function;
  law.force = is_spring ? "stiffness*e" : "damping*rate";
  law.parameters = {is_spring ? FormulaSymbol{"stiffness", "N/m", FormulaSymbol::none, "tension per elongation", 0.0}
                              : FormulaSymbol{"damping", "N s/m", FormulaSymbol::none, "tension per rate", 0.0}};
  return law;
}

std::vector<ProjectFile> files_of(const PluginProject& project) {
  const std::string type = type_of(project);
  const std::string_view other = project.kind == ComponentKind::integrator ? integrator_source : neuron_source;
  const std::string source =
      is_law(project) ? law_source(project, type)
                      : fmt::format(fmt::runtime(other), fmt::arg("name", project.name), fmt::arg("type", type));
  return {{project.name + ".cpp", source},
          {project.name + ".toml", scene_of(project)},
          {"CMakeLists.txt", fmt::format(cmake_text, fmt::arg("name", project.name))},
          {"test.cmake", test_of(project)},
          {"README.md", readme_of(project)}};
}

}  // namespace springnet::tool
