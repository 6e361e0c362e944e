// Uses of components, and laws given as formulas.
#include <cmath>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/formula.hpp>

#include "scene/writing.hpp"

namespace springnet::scene {
using namespace toml_text;

std::string text_of(const springnet_parameter& parameter, double value) {
  switch (parameter.type) {
    case SPRINGNET_BOOLEAN:
      return value != 0.0 ? "true" : "false";
    case SPRINGNET_CHOICE:
      return in_quotes(parameter.choices[static_cast<std::size_t>(value)]);
    case SPRINGNET_INTEGER:
      return fmt::format("{}", static_cast<std::int64_t>(value));
    default:
      return number(value);
  }
}

namespace {

std::string with_unit(double value, const std::string& unit) {
  return unit.empty() ? number(value) : in_quotes(fmt::format("{} {}", value, unit));
}

// Bounds, scale and summary; `table` gets the keys that are not at their defaults.
template <class Symbol>
bool add_metadata(const Symbol& symbol, bool excludes_smallest, double plain_scale, Inline& table) {
  bool any = false;
  const auto add = [&](const char* name, const std::string& value) {
    table.add(name, value);
    any = true;
  };
  if (symbol.smallest != -FormulaSymbol::infinity)
    add(excludes_smallest ? "above" : "smallest", number(symbol.smallest));
  if (symbol.largest != FormulaSymbol::infinity) add("largest", number(symbol.largest));
  if (!std::isnan(symbol.scale) && symbol.scale != plain_scale) add("scale", number(symbol.scale));
  if (!symbol.summary.empty()) add("summary", in_quotes(symbol.summary));
  return any;
}

std::string symbol_text(const FormulaSymbol& symbol, double value, bool learnable) {
  Inline table;
  table.add("value", with_unit(value, symbol.unit));
  bool any = add_metadata(symbol, symbol.excludes_smallest, learnable ? std::abs(value) : FormulaSymbol::none, table);
  if (learnable && !symbol.learnable) {
    table.add("learnable", "false");
    any = true;
  }
  return any ? table.text() : with_unit(value, symbol.unit);
}

std::string inputs_text(const std::vector<FormulaSymbol>& inputs) {
  bool plain = true;
  for (const FormulaSymbol& each : inputs) {
    Inline unused;
    plain = plain && std::isnan(each.preset) && each.unit.empty() &&
            !add_metadata(each, each.excludes_smallest, FormulaSymbol::none, unused);
  }
  if (plain) return list(inputs.size(), [&](std::size_t k) { return in_quotes(inputs[k].name); });
  Inline table;
  for (const FormulaSymbol& each : inputs)
    table.add(each.name, symbol_text(each, std::isnan(each.preset) ? 0.0 : each.preset, false));
  return table.text();
}

std::string states_text(const std::vector<FormulaState>& states) {
  Inline all;
  for (const FormulaState& each : states) {
    Inline table;
    table.add("rate", in_quotes(each.rate)).add("start", number(each.start));
    if (!each.unit.empty()) table.add("unit", in_quotes(each.unit));
    static_cast<void>(add_metadata(each, false, FormulaSymbol::none, table));
    all.add(each.name, table.text());
  }
  return all.text();
}

std::string formula_text(const LawFormula& law, const LawUse& use) {
  Inline table;
  if (!law.forces.empty()) {
    Inline forces;
    for (std::size_t k = 0; k < law.forces.size(); ++k) forces.add(law.scalars[k].name, in_quotes(law.forces[k]));
    table.add("formula", forces.text());
  } else if (!law.force.empty()) {
    table.add("formula", in_quotes(law.force));
  }
  if (!law.energy.empty()) table.add("energy", in_quotes(law.energy));
  if (!law.margin.empty()) table.add("margin", in_quotes(law.margin));
  if (!law.inputs.empty()) table.add("inputs", inputs_text(law.inputs));
  if (!law.curves.empty()) {
    Inline curves;
    for (const FormulaCurve& each : law.curves)
      curves.add(each.name, Inline().add("x", numbers(each.x)).add("y", numbers(each.y)).text());
    table.add("curves", curves.text());
  }
  if (!law.states.empty()) table.add("states", states_text(law.states));
  if (!law.scalars.empty()) {
    Inline scalars;
    for (const FormulaScalar& each : law.scalars) scalars.add(each.name, in_quotes(each.of));
    table.add("scalars", scalars.text());
  }
  if (law.smallest_stretch != 0.0 || law.largest_stretch != FormulaSymbol::infinity)
    table.add("stretch", fmt::format("[{}, {}]", number(law.smallest_stretch), number(law.largest_stretch)));
  std::vector<std::string> promises;
  const auto promise = [&](bool made, const char* words) {
    if (made) promises.push_back(in_quotes(words));
  };
  promise(law.pulls_only, "pulls only");
  promise(law.monotone, "monotone");
  promise(law.not_zero_at_rest, "not zero at rest");
  promise(law.adds_power, "adds power");
  promise(law.smooth_rates, "smooth rates");
  if (!promises.empty()) table.add("declares", list(promises.size(), [&](std::size_t k) { return promises[k]; }));
  if (!law.summary.empty()) table.add("summary", in_quotes(law.summary));
  const springnet_component& component = *use.component->description;
  for (std::uint32_t i = 0; i < component.parameter_count; ++i) {
    const std::string name = component.parameters[i]->name;
    const auto given = use.parameters.find(name);
    const double value = given != use.parameters.end() ? given->second : component.parameters[i]->default_value;
    FormulaSymbol symbol{name};
    for (const FormulaSymbol& each : law.parameters)
      if (each.name == name) symbol = each;
    table.add(name, symbol_text(symbol, value, true));
  }
  return table.text();
}

}  // namespace

std::string text_of(const LawUse& use, ComponentKind kind, const PluginHost& plugins, std::string_view name_key,
                    std::optional<double> mass) {
  if (use.component != nullptr)
    if (const LawFormula* const formula = formula_of(*use.component)) return formula_text(*formula, use);
  const std::shared_ptr<const Component> component =
      use.component != nullptr ? use.component : plugins.require(kind, use.id);
  if (use.component != nullptr && plugins.find(kind, use.id) != use.component)
    throw Error(ErrorKind::input,
                fmt::format("the {} '{}' is neither a formula nor of a plugin: a scene cannot name it; make a plugin "
                            "of it",
                            name_of(kind), use.id));
  Inline table;
  table.add(name_key, in_quotes(use.id));
  if (mass) table.add("mass", number(*mass));
  for (std::uint32_t i = 0; i < component->description->parameter_count; ++i) {
    const springnet_parameter& declared = *component->description->parameters[i];
    if (const auto given = use.parameters.find(std::string_view(declared.name)); given != use.parameters.end())
      table.add(declared.name, text_of(declared, given->second));
  }
  for (const auto& [name, values] : use.tables) table.add(name, numbers(values));
  return table.text();
}

void write_material(const Material& material, const PluginHost& plugins, bool with_none, Document& out) {
  const auto write = [&](const char* name, const std::optional<LawUse>& use, ComponentKind kind) {
    if (use)
      out.add(name, text_of(*use, kind, plugins));
    else if (with_none)
      out.add(name, in_quotes("none"));
  };
  write("spring", material.spring, ComponentKind::spring_function);
  write("viscosity", material.viscosity, ComponentKind::viscosity_function);
}

}  // namespace springnet::scene
