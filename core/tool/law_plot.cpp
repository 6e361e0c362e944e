#include "law_plot.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/output_folder.hpp>
#include <springnet/printable.hpp>
#include <springnet/scene.hpp>

#include "component_text.hpp"
#include "figure_page.hpp"
#include "law_figure.hpp"

namespace springnet::tool {

namespace {

// More would be a picture that nobody reads.
constexpr std::size_t most_laws = 24;

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorKind::input, what); }

std::optional<double> read_number(std::string_view text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

LawFigureOptions options_of(const PlotArguments& arguments) {
  LawFigureOptions options;
  options.reference = arguments.reference;
  options.period = arguments.period;
  if (arguments.range.empty()) return options;
  const std::size_t colon = arguments.range.find(':');
  if (colon == std::string::npos) refuse("--range: write FROM:TO, as in --range 0.5:2");
  const auto from = read_number(std::string_view(arguments.range).substr(0, colon));
  const auto to = read_number(std::string_view(arguments.range).substr(colon + 1));
  if (!from || !to || !(*from < *to)) refuse("--range: must be two numbers, the smaller one first, as in 0.5:2");
  options.range = {*from, *to};
  return options;
}

// "3", "true", or a choice by its name.
double read_value(const springnet_parameter& parameter, const std::string& text) {
  if (parameter.type == SPRINGNET_CHOICE) {
    const std::ptrdiff_t index = choice_index(parameter, text);
    if (index >= 0) return static_cast<double>(index);
    refuse(fmt::format("--set {}: '{}' is none of its choices", parameter.name, printable(text)));
  }
  if (parameter.type == SPRINGNET_BOOLEAN && (text == "true" || text == "false")) return text == "true" ? 1.0 : 0.0;
  const std::optional<double> number = read_number(text);
  if (!number) refuse(fmt::format("--set {}: '{}' is no number", parameter.name, printable(text)));
  return *number;
}

// With spaces that no line breaks at.
std::string with_value(const springnet_parameter& parameter, double value) {
  const std::string unit = parameter.type == SPRINGNET_NUMBER && std::string_view(parameter.unit) != "1"
                               ? "\u00a0" + shown(parameter.unit)
                               : "";
  return fmt::format("{}\u00a0=\u00a0{}{}", parameter.name, value_text(parameter, value), unit);
}

std::string listed(const std::vector<std::string>& items) { return fmt::format("{}", fmt::join(items, ", ")); }

std::string title_of(const Component& component) {
  return fmt::format("{} '{}'", name_of(component.kind()), component.id());
}

// A law by its name: what is not given is the default, or a sample value.
ShownLaw law_of_component(const std::shared_ptr<const Component>& shared, const PlotArguments& arguments) {
  const Component& component = *shared;
  LawSetting setting;
  setting.component = &component;
  ParameterValues given;
  std::map<std::string, double, std::less<>> signals;
  for (const std::string& each : arguments.sets) {
    const std::size_t equals = each.find('=');
    if (equals == std::string::npos || equals == 0)
      refuse(fmt::format("--set {}: write NAME=VALUE, as in --set stiffness=3", printable(each)));
    const std::string name = each.substr(0, equals), text = each.substr(equals + 1);
    const auto named = [&](const springnet_parameter* one) { return one->name == name; };
    const auto inputs = inputs_of(component), parameters = parameters_of(component);
    if (const auto input = std::find_if(inputs.begin(), inputs.end(), named); input != inputs.end()) {
      const double value = read_value(**input, text);
      if (const std::string wrong = check_value(**input, value); !wrong.empty())
        refuse(fmt::format("--set {}: {}", name, wrong));
      signals[name] = value;
      continue;
    }
    const auto parameter = std::find_if(parameters.begin(), parameters.end(), named);
    given[name] = parameter == parameters.end() ? 0.0 : read_value(**parameter, text);  // unknown: refused below
  }
  std::vector<std::string> values, assumed;
  ParameterValues all = given;
  for (const springnet_parameter* parameter : parameters_of(component)) {
    const bool is_given = given.contains(std::string_view(parameter->name));
    if (!is_given && required(*parameter)) {
      all[parameter->name] = sample_value(*parameter);
      assumed.emplace_back(parameter->name);
    }
  }
  setting.parameters = complete_parameters(*component.description, all, "--set");
  for (std::size_t k = 0; k < setting.parameters.size(); ++k)
    values.push_back(with_value(*parameters_of(component)[k], setting.parameters[k]));
  for (const springnet_parameter* input : inputs_of(component)) {
    const auto found = signals.find(std::string_view(input->name));
    setting.inputs.push_back(found == signals.end() ? input->default_value : found->second);
    values.push_back(with_value(*input, setting.inputs.back()));
  }
  setting.tables = sample_tables(component);
  std::vector<std::string> notes{shown(component.description->summary)};
  if (!values.empty()) notes.push_back(listed(values));
  if (!assumed.empty())
    notes.push_back(fmt::format("Not given, a sample value: {}. '--set NAME=VALUE' sets it.", listed(assumed)));
  if (!setting.tables.empty()) notes.emplace_back("Its tables are samples: a straight line. A scene's own are drawn.");
  return {shared, title_of(component), std::move(notes), std::move(setting), arguments.reference};
}

// A law of a scene's material. reference: of a spring or element that has it.
ShownLaw law_of_use(const std::shared_ptr<const Component>& shared, const LawUse& use, double reference,
                    const std::string& users, const PlotArguments& arguments) {
  const Component& component = *shared;
  LawSetting setting;
  setting.component = &component;
  setting.parameters = complete_parameters(*component.description, use.parameters, component.id());
  for (const std::span<const double> table : complete_tables(*component.description, use.tables, component.id()))
    setting.tables.emplace_back(table.begin(), table.end());
  std::vector<std::string> values;
  for (std::size_t k = 0; k < setting.parameters.size(); ++k) {
    const springnet_parameter& parameter = *parameters_of(component)[k];
    values.push_back(with_value(parameter, setting.parameters[k]));
  }
  for (const springnet_parameter* input : inputs_of(component)) {
    setting.inputs.push_back(input->default_value);
    values.push_back(with_value(*input, input->default_value));
  }
  const bool is_formula = use.component != nullptr;
  std::vector<std::string> notes{shown(component.description->summary)};
  if (!values.empty()) notes.push_back(listed(values));
  notes.push_back(users);
  const std::string title =
      is_formula ? fmt::format("{} by a formula", name_of(component.kind())) : title_of(component);
  return {shared, title, std::move(notes), std::move(setting), reference > 0.0 ? reference : arguments.reference};
}

// Of a material, and the rest value of the first.
struct Users {
  std::size_t springs = 0, elements = 0;
  double reference = 0.0;
};

// "Of 12 springs, the first 0.5 m long at rest."
std::string text_of_users(const Users& users, const Component& component) {
  const std::size_t count = users.springs > 0 ? users.springs : users.elements;
  const char* const what = users.springs > 0 ? "spring" : "element";
  std::string text = fmt::format("Of {} {}{}", count, what, count == 1 ? "" : "s");
  const std::uint32_t invariant = component.law().invariant;
  if (invariant == SPRINGNET_RELATIVE_SPEED || invariant == SPRINGNET_SEVERAL) return text + ".";
  return text + fmt::format("; rest value{} {:g}{}.", count == 1 ? "" : " of the first", users.reference,
                            users.springs > 0 ? " m" : "");
}

void write_plot(const std::string& title, const std::vector<ShownLaw>& laws, const PlotArguments& arguments) {
  std::vector<Figure> figures;
  for (const ShownLaw& law : laws) {
    LawFigureOptions options = options_of(arguments);
    options.reference = law.reference;
    figures.push_back(figure_of(law.title, law.notes, law.setting, options));
  }
  write_figures(arguments.file, title, figures);
}

}  // namespace

void PlotArguments::add_to(CLI::App& command) {
  command
      .add_option(
          "--plot", file,
          "Draw force, stiffness and energy of laws to FILE.svg, or to a page FILE.html that shows the values at "
          "the pointer")
      ->type_name("FILE");
  command
      .add_option("--set", sets,
                  "With --plot or --at: a parameter or input of the law, or a key of the scene. May be repeated")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--range", range,
                  "With --plot: stretches to draw; of laws on speeds m/s, on the angle of a hinge or chain rad "
                  "[0.5:1.5, within the law's range]")
      ->type_name("FROM:TO");
  command
      .add_option("--reference", reference,
                  "With --plot or --at: rest length, or rest value of an angle, area or volume [1]")
      ->type_name("VALUE")
      ->check(number_between(above_zero, finite));
  command
      .add_option(
          "--at", at,
          "Print force, stiffness, energy and margin of laws at these lengths (m), angles (rad), areas, volumes or "
          "relative speeds (m/s); of elements over several scalars at these stretches")
      ->type_name("VALUE,…")
      ->delimiter(',')
      ->check(number_between(-finite, finite));
  command.add_option("--rate", rate, "With --at: the rate of the value, in its unit per second [0]")
      ->type_name("VALUE")
      ->check(number_between(-finite, finite));
  command.add_option("--period", period, "With --plot: of the cycles of a law with internal states, s [1]")
      ->type_name("S")
      ->check(number_between(above_zero, finite));
}

std::vector<ShownLaw> laws_of_components(const std::vector<std::shared_ptr<const Component>>& components,
                                         const PlotArguments& arguments) {
  std::vector<ShownLaw> laws;
  for (const auto& component : components)
    if (is_law(*component)) laws.push_back(law_of_component(component, arguments));
  if (laws.empty())
    refuse(fmt::format("{} is no law; --plot and --at are for spring functions and viscosity functions",
                       title_of(*components.front())));
  return laws;
}

ShownScene laws_of_scene(const std::filesystem::path& file, const PluginHost& host, const PlotArguments& arguments) {
  std::vector<SceneOverride> overrides;
  for (const std::string& each : arguments.sets) overrides.push_back(parse_override(each));
  const Scene scene = load_scene(file, host, overrides);
  const Network& network = scene.network;
  const std::vector<Material>& materials = network.materials();
  std::vector<Users> users(materials.size());
  for (std::size_t k = 0; k < network.springs().size(); ++k) {
    const Spring& spring = network.springs()[k];
    Users& of = users[spring.material];
    if (of.springs++ == 0) of.reference = spring.rest_length;
  }
  for (const Element& element : network.elements()) {
    Users& of = users[element.material];
    if (of.elements++ == 0 && of.springs == 0) of.reference = std::abs(element.reference);
  }
  ShownScene shown_scene;
  for (std::size_t k = 0; k < materials.size(); ++k) {
    if (users[k].springs + users[k].elements == 0) continue;
    const auto add = [&](const std::optional<LawUse>& use, ComponentKind kind) {
      if (!use) return;
      if (shown_scene.laws.size() == most_laws) {
        ++shown_scene.left_out;
        return;
      }
      const std::shared_ptr<const Component> component = use->component ? use->component : host.require(kind, use->id);
      const std::string text = text_of_users(users[k], *component);
      shown_scene.laws.push_back(law_of_use(component, *use, users[k].reference, text, arguments));
    };
    add(materials[k].spring, ComponentKind::spring_function);
    add(materials[k].viscosity, ComponentKind::viscosity_function);
  }
  if (shown_scene.laws.empty())
    refuse(fmt::format("{}: no spring or element has a law", printable_message(file.string())));
  shown_scene.title = scene.title.empty() ? file.filename().string() : printable(scene.title, 100);
  return shown_scene;
}

void plot_components(const std::vector<std::shared_ptr<const Component>>& components, const PlotArguments& arguments) {
  require_ending(arguments.file);
  write_plot(std::string(components.front()->id()), laws_of_components(components, arguments), arguments);
}

std::vector<std::string> plot_scene(const std::filesystem::path& file, const PluginHost& host,
                                    const PlotArguments& arguments) {
  require_ending(arguments.file);
  const ShownScene scene = laws_of_scene(file, host, arguments);
  write_plot(scene.title, scene.laws, arguments);
  if (scene.left_out == 0) return {};
  return {fmt::format("{} further laws of the scene's materials are not drawn", scene.left_out)};
}

}  // namespace springnet::tool
