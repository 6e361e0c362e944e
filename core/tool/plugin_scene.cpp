#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/formula_source.hpp>

#include "kind_word.hpp"
#include "plugin_project.hpp"

namespace springnet::tool {

namespace {

constexpr std::string_view start_text =
    R"({about}. scene.md of the documentation describes every key.
#   springnet run {name}.toml --plugins build
title = "{title}"

[simulation]
duration   = 2.0    # s
time_step  = {time_step}  # s
integrator = {integrator}

[output]
interval = 0.02  # s between records

[gravity]
acceleration = [0, 0, {gravity}]  # m/s^2
)";

constexpr std::string_view springs_text =
    R"(
[[body]]
name      = "chain"
nodes     = [[0, 0, 0], [0, 0, -{length:g}], [0, {aside:g}, -{depth:g}]]  # m
springs   = [[0, 1], [1, 2]]
neuron    = {neuron}
spring    = {spring}
viscosity = {viscosity}

[[fix]]
select = {{ nodes = [0] }}
)";

// The law is that of elements of a body that hangs from its left end.
constexpr std::string_view elements_text =
    R"(
[[body]]
name      = "net"
{shape}
neuron    = {neuron}
spring    = {{ type = "linear", stiffness = 10.0 }}  # N/m
viscosity = {{ type = "linear", damping = 0.05 }}  # N s/m

[[element]]
invariant = "{invariant}"
select    = {{ body = "net" }}
{direction}{key} = {law}

[[fix]]
select = {{ body = "net", box = {{ min = [-1, -1, -1], max = [0.01, 2, 2] }} }}
)";

// 1.0, 0.25, 1e-05
std::string decimal(double value) {
  std::string text = fmt::format("{}", value);
  if (std::isfinite(value) && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

// { type = "…", stiffness = 1.0 }
std::string use_of(const PluginProject& project, const LawInScene& law) {
  std::string text = "{ " + law.type;
  for (const std::string& name : source_of(law_of(project)).parameters) {
    const auto known = project.values.find(name);
    text += fmt::format(", {} = {}", name, decimal(known == project.values.end() ? project.value : known->second));
  }
  return text + (law.tables.empty() ? "" : ", " + law.tables) + " }";
}

// "  # N/m, m", of the law's parameters in their order, or nothing if that is not known of all.
std::string units_of(const PluginProject& project) {
  const LawFormula law = law_of(project);
  std::vector<std::string> units;
  for (const std::string& name : source_of(law).parameters)
    for (const FormulaSymbol& each : law.parameters)
      if (each.name == name) units.push_back(each.unit);
  const auto is_empty = [](const std::string& unit) { return unit.empty(); };
  if (units.empty() || std::any_of(units.begin(), units.end(), is_empty)) return "";
  return fmt::format("  # {}", fmt::join(units, ", "));
}

// The invariant of an [[element]] for a law that springs cannot have; empty: they can.
std::string_view invariant_of(const LawFormula& law) {
  if (!law.scalars.empty()) return name_of(law.shape);
  switch (component_of(law)->law().invariant) {
    case SPRINGNET_ANGLE:
      return "angle";
    case SPRINGNET_AREA:
      return "area";
    case SPRINGNET_VOLUME:
      return "volume";
    default:
      return "";
  }
}

std::string_view shape_of(std::string_view invariant) {
  if (invariant == "angle" || invariant == "chain")
    return "nodes     = [[0, 0, 0], [0, 1, 0], [1, 1, 0]]  # m\nsprings   = [[0, 1], [1, 2]]";
  if (invariant == "volume" || invariant == "tetrahedron")
    return "mesh      = { lattice = [3, 2, 2], spacing = 0.5 }  # m";
  return "mesh      = { lattice = [3, 2, 1], spacing = 0.5 }  # m";
}

// A signal for each input, which grows a little from what it is without one.
std::string signals_of(const LawFormula& law) {
  std::string text;
  for (const FormulaSymbol& input : law.inputs) {
    const double from = std::isnan(input.preset) ? 0.0 : input.preset;
    const double to = std::clamp(from + 0.1, input.smallest, input.largest);
    text += fmt::format("\n[[input]]\ninput  = \"{}\"\ntimes  = [0, 1]  # s\nvalues = [{}, {}]\n", input.name,
                        decimal(from), decimal(to));
  }
  return text;
}

// law: how its use says what it is.
std::string scene_with(const PluginProject& project, const LawInScene& law) {
  std::string neuron = fmt::format("{{ type = \"point_mass\", mass = {} }}  # kg", decimal(project.mass));
  std::string spring = "{ type = \"linear\", stiffness = 1.0 }  # N/m";
  std::string viscosity = "{ type = \"linear\", damping = 0.02 }  # N s/m";
  std::string integrator = "{ name = \"recurrent\", theta = 0.5 }", invariant, use;
  switch (project.kind) {
    case ComponentKind::spring_function:
      spring = use = use_of(project, law) + units_of(project);
      break;
    case ComponentKind::viscosity_function:
      viscosity = use = use_of(project, law) + units_of(project);
      break;
    case ComponentKind::neuron:
      neuron = "{ " + law.type + ", mass = 0.01, drag = 0.005 }  # kg, kg/s";
      break;
    case ComponentKind::integrator:
      integrator = "{ " + law.type + " }";
      break;
  }
  if (is_law(project)) invariant = invariant_of(law_of(project));
  const bool of_elements = !invariant.empty();
  std::string text =
      fmt::format(start_text, fmt::arg("name", project.name),
                  fmt::arg("about", of_elements ? "# A body with elements that have the law hangs from its left end"
                                                : "# Two masses hang one below the other and come to rest"),
                  fmt::arg("title", fmt::format("{} with the {} {}", of_elements ? "A body" : "Two masses",
                                                kind_word(project.kind), project.name)),
                  fmt::arg("time_step", fmt::format("{:g}", project.time_step)), fmt::arg("integrator", integrator),
                  fmt::arg("gravity", of_elements ? "-1.0" : "-9.81"));
  if (!of_elements)
    return text +
           fmt::format(springs_text, fmt::arg("length", project.rest), fmt::arg("aside", 0.1 * project.rest),
                       fmt::arg("depth", 2.0 * project.rest), fmt::arg("neuron", neuron), fmt::arg("spring", spring),
                       fmt::arg("viscosity", viscosity)) +
           signals_of(law_of(project));
  const bool is_spring = project.kind == ComponentKind::spring_function;
  const bool is_directed = component_of(law_of(project))->law().reads_direction != 0;
  return text +
         fmt::format(elements_text, fmt::arg("shape", shape_of(invariant)), fmt::arg("neuron", neuron),
                     fmt::arg("invariant", invariant),
                     fmt::arg("direction", is_directed ? "direction = [1, 0, 0]\n" : ""),
                     fmt::arg("key", is_spring ? "spring   " : "viscosity"), fmt::arg("law", use)) +
         signals_of(law_of(project));
}

// { flow = { rate = "…", start = 0.0 } }, with what changes steps.
std::string states_text(const LawFormula& law) {
  std::vector<std::string> entries;
  for (const FormulaState& each : law.states) {
    std::string text =
        fmt::format("{} = {{ rate = \"{}\", start = {}", each.name, in_one_line(each.rate), decimal(each.start));
    if (std::isfinite(each.smallest)) text += fmt::format(", smallest = {}", decimal(each.smallest));
    if (std::isfinite(each.largest)) text += fmt::format(", largest = {}", decimal(each.largest));
    if (!std::isnan(each.scale)) text += fmt::format(", scale = {}", decimal(each.scale));
    entries.push_back(text + " }");
  }
  return fmt::format("states = {{ {} }}", fmt::join(entries, ", "));
}

std::string points_text(const std::vector<double>& points) {
  std::vector<std::string> numbers;
  numbers.reserve(points.size());
  for (const double each : points) numbers.push_back(decimal(each));
  return fmt::format("[{}]", fmt::join(numbers, ", "));
}

// name = text, …
template <class List, class Entry>
std::string table_text(const char* key, const List& list, const Entry& entry) {
  std::vector<std::string> entries;
  for (const auto& each : list) entries.push_back(fmt::format("{} = {}", each.name, entry(each)));
  return fmt::format("{} = {{ {} }}", key, fmt::join(entries, ", "));
}

}  // namespace

LawInScene plugin_in_scene(const PluginProject& project) {
  const bool is_integrator = project.kind == ComponentKind::integrator;
  LawInScene result{fmt::format("{} = \"{}\"", is_integrator ? "name" : "type", project.name), ""};
  if (!is_law(project)) return result;
  const LawFormula law = law_of(project);
  const std::vector<std::string> keys = source_of(law).table_keys;
  std::vector<std::string> tables;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const FormulaCurve& curve = law.curves[k / 2];
    tables.push_back(fmt::format("{} = {}", keys[k], points_text(k % 2 == 0 ? curve.x : curve.y)));
  }
  result.tables = fmt::format("{}", fmt::join(tables, ", "));
  return result;
}

LawInScene formula_in_scene(const PluginProject& project) {
  const LawFormula law = law_of(project);
  std::vector<std::string> keys;
  const auto add = [&](const char* key, const std::string& formula) {
    if (!formula.empty()) keys.push_back(fmt::format("{} = \"{}\"", key, in_one_line(formula)));
  };
  add("formula", law.force);
  if (!law.forces.empty()) {
    std::vector<std::string> forces;
    for (std::size_t k = 0; k < law.forces.size(); ++k)
      forces.push_back(fmt::format("{} = \"{}\"", law.scalars[k].name, in_one_line(law.forces[k])));
    keys.push_back(fmt::format("formula = {{ {} }}", fmt::join(forces, ", ")));
  }
  add("energy", law.energy);
  add("margin", law.margin);
  if (!law.inputs.empty())
    keys.push_back(table_text("inputs", law.inputs, [](const FormulaSymbol& each) {
      return decimal(std::isnan(each.preset) ? 0.0 : each.preset);
    }));
  if (!law.states.empty()) keys.push_back(states_text(law));
  if (law.smooth_rates) keys.emplace_back("declares = [\"smooth rates\"]");
  if (!law.scalars.empty())
    keys.push_back(
        table_text("scalars", law.scalars, [](const FormulaScalar& each) { return fmt::format("\"{}\"", each.of); }));
  LawInScene result{fmt::format("{}", fmt::join(keys, ", ")), ""};
  if (!law.curves.empty())
    result.tables = table_text("curves", law.curves, [](const FormulaCurve& each) {
      return fmt::format("{{ x = {}, y = {} }}", points_text(each.x), points_text(each.y));
    });
  return result;
}

std::string scene_of(const PluginProject& project) { return scene_with(project, plugin_in_scene(project)); }

std::string scene_with_formula(const PluginProject& project) { return scene_with(project, formula_in_scene(project)); }

}  // namespace springnet::tool
