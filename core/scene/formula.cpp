#include "scene/formula.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/error.hpp>
#include <springnet/formula.hpp>
#include <springnet/suggestion.hpp>

#include "formula/expression.hpp"
#include "scene/formula_numbers.hpp"

namespace springnet::scene {
namespace {

constexpr std::array<std::string_view, 10> own_keys{"formula", "energy",  "margin",  "inputs",   "curves",
                                                    "states",  "scalars", "stretch", "declares", "summary"};
// A misspelt one, in a table without `type`, is told where it stands.
const std::vector<std::string> formula_words{"formula", "energy"};
constexpr std::size_t most_points = 100'000;

void read_inputs(const Value& inputs, LawFormula& law) {
  if (inputs.is_list()) {
    for (const Value& name : inputs.elements()) law.inputs.push_back({name.text()});
    return;
  }
  if (inputs.is_text()) inputs.fail("must be a list of names, as [\"drive\"], or a table of names and values");
  const Table table = inputs.open_table("inputs");
  for (const std::string& name : table.keys()) {
    NumberOfFormula input = read_number(name, *table.find_parameter(name), false);
    input.symbol.preset = input.value;
    law.inputs.push_back(std::move(input.symbol));
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

void read_scalars(const Value& scalars, LawFormula& law) {
  const Table list = scalars.open_table("scalars");
  for (const std::string& name : list.keys()) law.scalars.push_back({name, list.find_parameter(name)->text()});
  if (law.scalars.empty()) scalars.fail("lists none; write scalars = { a = \"length(0, 1)\", … }");
}

// [smallest, largest]
void read_stretch(const Value& stretch, LawFormula& law, bool of_lengths) {
  if (!stretch.is_list()) stretch.wrong_type("two numbers [smallest, largest]");
  const std::vector<Value> bounds = stretch.elements(2);
  law.smallest_stretch = bounds[0].number();
  law.largest_stretch = bounds[1].coordinate();
  if (of_lengths && law.smallest_stretch < 0.0)
    bounds[0].fail(fmt::format("must be at least 0, as lengths are, is {}", law.smallest_stretch));
  if (!(law.smallest_stretch < law.largest_stretch))
    bounds[1].fail(
        fmt::format("must be above the smallest stretch, {}, is {}", law.smallest_stretch, law.largest_stretch));
}

void read_promises(const Value& declares, LawFormula& law) {
  static const std::vector<std::string> words{"pulls only", "monotone", "not zero at rest", "adds power",
                                              "smooth rates"};
  bool* const promises[] = {&law.pulls_only, &law.monotone, &law.not_zero_at_rest, &law.adds_power, &law.smooth_rates};
  for (const Value& each : declares.elements()) {
    bool& promise = *promises[each.choice(words)];
    if (promise) each.fail("is listed twice; remove one");
    promise = true;
    if (&promise == &law.smooth_rates && law.states.empty())
      each.fail("has no meaning for a law without 'states'; remove it");
  }
}

// Every other key is one; what cannot be is a misspelt key.
NumberOfFormula read_parameter(const std::string& name, const Value& value) {
  try {
    return read_number(name, value, true);
  } catch (const Error& error) {
    const std::string near = suggestion(name, {own_keys.begin(), own_keys.end()});
    if (near.empty()) throw;
    throw Error(error.kind(), fmt::format("{}; if '{}' is no parameter: {}", error.what(), name, near));
  }
}

void read_forces(const Value& formula, LawFormula& law) {
  const Table forces = formula.open_table("formula");
  for (const FormulaScalar& scalar : law.scalars) {
    const auto force = forces.find_parameter(scalar.name);
    law.forces.push_back(force ? force->prose(formula::max_length) : "0");
  }
  for (const std::string& name : forces.keys())
    if (std::none_of(law.scalars.begin(), law.scalars.end(), [&](const auto& each) { return each.name == name; }))
      forces.find_parameter(name)->fail("'scalars' has no such name; list it there, or correct it");
}

// Those that the formulas name. Their units count if the law's own parameters have units.
void add_given(const Table& table, const Value& place, const std::vector<MaterialParameter>& given, LawFormula& law,
               ParameterValues& values) {
  if (given.empty()) return;
  const std::vector<std::string> names = place.at_this_place([&] { return parameters_of(law); });
  const bool has_units = std::any_of(law.parameters.begin(), law.parameters.end(),
                                     [](const FormulaSymbol& each) { return !each.unit.empty(); });
  for (const MaterialParameter& each : given) {
    if (const auto own = table.find_parameter(each.name)) own->fail("is set by the material here; remove it");
    if (std::find(names.begin(), names.end(), each.name) == names.end()) continue;
    law.parameters.push_back({each.name, has_units ? each.unit : ""});
    values.emplace(each.name, each.value());
  }
}

// All that a formula's component is made of, but for scales of parameters, which mostly come from their values: those
// of the first use count.
std::string key_of(const LawFormula& law) {
  std::string key = fmt::format("{}|{}|{}|{}|{}{}{}{}{}", static_cast<int>(law.kind), static_cast<int>(law.shape),
                                law.smallest_stretch, law.largest_stretch, law.pulls_only, law.monotone,
                                law.not_zero_at_rest, law.adds_power, law.smooth_rates);
  const auto add = [&](const auto&... parts) { ((key += fmt::format("|{}", parts)), ...); };
  const auto add_text = [&](const std::string& text) { add(text.size(), text); };
  for (const std::string* text : {&law.force, &law.energy, &law.margin, &law.summary}) add_text(*text);
  for (const std::vector<FormulaSymbol>* list : {&law.parameters, &law.inputs})
    for (const FormulaSymbol& each : *list) {
      for (const std::string* text : {&each.name, &each.unit, &each.summary}) add_text(*text);
      add(list == &law.inputs, each.preset, each.smallest, each.largest, each.excludes_smallest, each.learnable);
    }
  for (const FormulaCurve& each : law.curves) {
    add_text(each.name);
    for (const std::vector<double>* list : {&each.x, &each.y}) add(fmt::format("{}", fmt::join(*list, ",")));
  }
  for (const FormulaState& each : law.states) {
    for (const std::string* text : {&each.name, &each.rate, &each.unit, &each.summary}) add_text(*text);
    add(each.start, each.smallest, each.largest, each.scale);
  }
  for (const FormulaScalar& each : law.scalars) {
    add_text(each.name);
    add_text(each.of);
  }
  for (const std::string& each : law.forces) add_text(each);
  return key;
}

LawUse use_of(const LawFormula& law, const ParameterValues& values, const Files& files) {
  if (files.formulas != nullptr) return law_of(law, values);  // each place is told apart
  std::shared_ptr<const Component>& known = (*files.known_formulas)[key_of(law)];
  LawUse use = known == nullptr ? law_of(law, values) : LawUse{"formula", values, {}, known};
  known = use.component;
  return use;
}

}  // namespace

bool is_key_of_formulas(std::string_view key) {
  return std::find(own_keys.begin(), own_keys.end(), key) != own_keys.end();
}

bool is_formula_of(const Table& table) {
  if (table.find_parameter("formula").has_value()) return true;
  if (table.find_parameter("type").has_value()) return false;
  if (table.find_parameter("energy").has_value()) return true;
  for (const std::string& key : table.keys())
    if (const Value value = *table.find_parameter(key); value.is_text() && suggestion(key, formula_words) != "")
      value.fail(fmt::format("is no key of a law; {}", suggestion(key, formula_words)));
  return false;
}

std::optional<Invariant> shape_of_formula(const Table& table) {
  const auto scalars = table.find_parameter("scalars");
  if (!scalars) return std::nullopt;
  LawFormula law;
  read_scalars(*scalars, law);
  const Invariant shape = scalars->at_this_place([&] { return shape_of(law.scalars); });
  return shape == Invariant::chain ? Invariant::triangle : shape;  // no body is made of chains
}

LawUse read_formula(const Table& table, ComponentKind kind, const Files& files, std::optional<Invariant> elements,
                    const std::vector<MaterialParameter>& given) {
  if (const auto type = table.find_parameter("type"))
    type->fail("cannot be combined with 'formula'; remove one of them");
  LawFormula law;
  law.kind = kind;
  const auto formula = table.find_parameter("formula");
  const auto scalars = table.find_parameter("scalars");
  const auto stretch = table.find_parameter("stretch");
  const bool several = elements && reads_several(*elements);
  if (scalars && !several)
    scalars->fail(
        "has no meaning here; laws over several scalars are for elements of the invariants chain, triangle, "
        "hinge and tetrahedron");
  if (several) law.shape = *elements;
  if (several && !scalars)
    table.fail("has no 'scalars', which say what the formula reads; add scalars = { a = \"length(0, 1)\", … }");
  if (scalars) read_scalars(*scalars, law);
  if (formula && several)
    read_forces(*formula, law);
  else if (formula)
    law.force = formula->prose(formula::max_length);
  if (const auto energy = table.find_parameter("energy")) law.energy = energy->prose(formula::max_length);
  if (const auto margin = table.find_parameter("margin")) law.margin = margin->prose(formula::max_length);
  if (const auto inputs = table.find_parameter("inputs")) read_inputs(*inputs, law);
  if (const auto states = table.find_parameter("states")) law.states = read_states(*states);
  if (const auto curves = table.find_parameter("curves")) read_curves(*curves, law);
  if (stretch && several) stretch->fail("has no meaning for a law over several scalars; remove it");
  if (stretch) read_stretch(*stretch, law, !elements);
  if (const auto declares = table.find_parameter("declares")) read_promises(*declares, law);
  if (const auto summary = table.find_parameter("summary")) law.summary = summary->text();
  ParameterValues values;
  for (const std::string& name : table.keys()) {
    if (is_key_of_formulas(name)) continue;
    NumberOfFormula parameter = read_parameter(name, *table.find_parameter(name));
    law.parameters.push_back(std::move(parameter.symbol));
    values.emplace(name, parameter.value);
  }
  const Value place = formula ? *formula : *table.find_parameter("energy");
  add_given(table, place, given, law, values);
  LawUse use = place.at_this_place([&] { return use_of(law, values, files); });
  place.at_this_place([&] { check_units(law, elements); });
  if (stretch && use.component->law().invariant == SPRINGNET_RELATIVE_SPEED)
    stretch->fail("has no meaning for a law of the relative speed; remove it");
  if (files.formulas != nullptr) files.formulas->push_back({table.value().path(), use, 0.0});
  return use;
}

}  // namespace springnet::scene
