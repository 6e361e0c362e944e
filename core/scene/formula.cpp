#include "scene/formula.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include <springnet/formula.hpp>

namespace springnet::scene {
namespace {

constexpr std::array<std::string_view, 7> own_keys{"formula", "energy", "margin", "inputs",
                                                   "curves",  "states", "scalars"};
constexpr std::size_t most_points = 100'000;

// A number, or a text of a number and its unit.
struct Quantity {
  double value;
  std::string unit;  // empty: not given
};
Quantity read_quantity(const Value& value) {
  if (!value.is_text()) return {value.number(), ""};
  const std::string text = value.text();
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || !std::isfinite(number))
    value.fail("must be a number, or a number and its unit, as \"3 N/m\"");
  std::string unit(end, text.data() + text.size());
  unit.erase(0, unit.find_first_not_of(' '));
  if (unit.empty()) value.fail("has no unit after the number; write \"3 N/m\", or the number without quotes");
  return {number, unit};
}

void read_inputs(const Value& inputs, LawFormula& law) {
  if (inputs.is_list()) {
    for (const Value& name : inputs.elements()) law.inputs.push_back({name.text()});
    return;
  }
  const Table table = inputs.open_table("inputs");
  for (const std::string& name : table.keys()) {
    const Quantity preset = read_quantity(*table.find_parameter(name));
    law.inputs.push_back({name, preset.unit, preset.value});
  }
}

void read_curves(const Value& curves, LawFormula& law) {
  const Table table = curves.open_table("curves");
  for (const std::string& name : table.keys()) {
    const Value points = *table.find_parameter(name);
    const Table both = points.open_table("curve");
    const auto numbers = [&](const char* key) {
      const auto list = both.find_parameter(key);
      if (!list) points.fail(fmt::format("has no '{}'; write {{ x = […], y = […] }}", key));
      return list->numbers(most_points);
    };
    law.curves.push_back({name, numbers("x"), numbers("y")});
    if (both.keys().size() > 2) points.fail("has other keys than 'x' and 'y'; remove them");
  }
}

// { name = { rate = "…", start = 0.0 } }
void read_states(const Value& states, LawFormula& law) {
  const Table table = states.open_table("states");
  for (const std::string& name : table.keys()) {
    const Value value = *table.find_parameter(name);
    const Table own = value.open_table("state");
    FormulaState state{name, "", 0.0, ""};
    const auto rate = own.find_parameter("rate");
    if (!rate) value.fail("has no 'rate'; write { rate = \"…\", start = 0.0 }");
    state.rate = rate->prose();
    if (const auto start = own.find_parameter("start")) {
      const Quantity quantity = read_quantity(*start);
      state.start = quantity.value;
      state.unit = quantity.unit;
    }
    for (const std::string& key : own.keys())
      if (key != "rate" && key != "start")
        own.find_parameter(key)->fail("is no key of a state, which has 'rate' and 'start'; remove it");
    law.states.push_back(std::move(state));
  }
}

}  // namespace

bool is_formula_of(const Table& table) {
  return table.find_parameter("formula").has_value() ||
         (table.find_parameter("energy").has_value() && !table.find_parameter("type").has_value());
}

LawUse read_formula(const Table& table, ComponentKind kind, std::optional<Invariant> shape) {
  if (const auto type = table.find_parameter("type"))
    type->fail("cannot be combined with 'formula'; remove one of them");
  LawFormula law;
  law.kind = kind;
  const auto formula = table.find_parameter("formula");
  const auto scalars = table.find_parameter("scalars");
  if (scalars && !shape)
    scalars->fail(
        "has no meaning here; laws over several scalars are for elements of the invariants chain, triangle, "
        "hinge and tetrahedron");
  if (shape) law.shape = *shape;
  if (shape && !scalars)
    table.fail("has no 'scalars', which say what the formula reads; add scalars = { a = \"length(0, 1)\", … }");
  if (scalars) {
    const Table list = scalars->open_table("scalars");
    for (const std::string& name : list.keys()) law.scalars.push_back({name, list.find_parameter(name)->text()});
    if (law.scalars.empty()) scalars->fail("lists none; write scalars = { a = \"length(0, 1)\", … }");
  }
  if (formula && shape) {
    const Table forces = formula->open_table("formula");
    for (const FormulaScalar& scalar : law.scalars) {
      const auto force = forces.find_parameter(scalar.name);
      law.forces.push_back(force ? force->prose() : "0");
    }
    for (const std::string& name : forces.keys())
      if (std::none_of(law.scalars.begin(), law.scalars.end(), [&](const auto& each) { return each.name == name; }))
        forces.find_parameter(name)->fail("'scalars' has no such name; list it there, or correct it");
  } else if (formula) {
    law.force = formula->prose();
  }
  if (const auto energy = table.find_parameter("energy")) law.energy = energy->prose();
  if (const auto margin = table.find_parameter("margin")) law.margin = margin->prose();
  if (const auto inputs = table.find_parameter("inputs")) read_inputs(*inputs, law);
  if (const auto states = table.find_parameter("states")) read_states(*states, law);
  if (const auto curves = table.find_parameter("curves")) read_curves(*curves, law);
  ParameterValues values;
  for (const std::string& name : table.keys()) {
    if (std::find(own_keys.begin(), own_keys.end(), name) != own_keys.end()) continue;
    const Quantity quantity = read_quantity(*table.find_parameter(name));
    law.parameters.push_back({name, quantity.unit});
    values.emplace(name, quantity.value);
  }
  const Value place = formula ? *formula : *table.find_parameter("energy");
  return place.at_this_place([&] { return law_of(law, values); });
}

}  // namespace springnet::scene
