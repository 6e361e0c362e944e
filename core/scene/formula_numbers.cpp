#include "scene/formula_numbers.hpp"

#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "formula/expression.hpp"

namespace springnet::scene {
namespace {

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
  if (unit.empty())
    value.fail(
        "has no unit after the number; write \"3 N/m\", \"3 1\" for a number without unit, or the number without "
        "quotes");
  return {number, unit};
}

// Bounds, scale and summary, which parameters, inputs and states have alike.
template <class Symbol>
void read_metadata(const Table& table, Symbol& symbol) {
  if (const auto smallest = table.find_parameter("smallest")) symbol.smallest = smallest->coordinate();
  if (const auto largest = table.find_parameter("largest")) {
    symbol.largest = largest->coordinate();
    if (!(symbol.smallest <= symbol.largest))
      largest->fail(fmt::format("must be at least the smallest, {}, is {}", symbol.smallest, symbol.largest));
  }
  if (const auto scale = table.find_parameter("scale")) {
    if (!scale->is_number()) scale->fail("must be a number above 0, the typical magnitude");
    symbol.scale = scale->number_above_0(symbol.unit);
  }
  if (const auto summary = table.find_parameter("summary")) symbol.summary = summary->text();
}

// As for a parameter of a plugin.
void check_bounds(const Value& value, double number, const std::string& unit, double smallest, double largest,
                  bool excludes_smallest) {
  springnet_parameter bounds{};
  bounds.struct_size = sizeof bounds;
  bounds.type = SPRINGNET_NUMBER;
  bounds.unit = unit.empty() ? "1" : unit.c_str();
  bounds.smallest = smallest;
  bounds.largest = largest;
  if (excludes_smallest) bounds.flags = SPRINGNET_EXCLUDES_SMALLEST;
  if (const std::string wrong = check_value(bounds, number); !wrong.empty()) value.fail(wrong);
}

FormulaState read_state(const std::string& name, const Value& value) {
  const Table table = value.open_table("state");
  table.check_keys({"rate", "start", "unit", "smallest", "largest", "scale", "summary"}, "a state");
  FormulaState state{name, ""};
  const auto rate = table.find_parameter("rate");
  if (!rate) value.fail("has no 'rate'; write { rate = \"…\", start = 0.0 }");
  state.rate = rate->prose(formula::max_length);
  const auto start = table.find_parameter("start");
  if (start) {
    const Quantity quantity = read_quantity(*start);
    state.start = quantity.value;
    state.unit = quantity.unit;
  }
  if (const auto unit = table.find_parameter("unit")) {
    const std::string text = unit->text();
    if (!state.unit.empty() && state.unit != text)
      unit->fail(fmt::format("is '{}', and 'start' is in {}; say it once", text, state.unit));
    state.unit = text;
  }
  read_metadata(table, state);
  check_bounds(start ? *start : value, state.start, state.unit, state.smallest, state.largest, false);
  return state;
}

}  // namespace

NumberOfFormula read_number(const std::string& name, const Value& given, bool learnable) {
  NumberOfFormula result{{name}, 0.0};
  FormulaSymbol& symbol = result.symbol;
  const auto take = [&](const Value& value) {
    Quantity quantity = read_quantity(value);
    result.value = quantity.value;
    symbol.unit = std::move(quantity.unit);
  };
  if (given.is_table()) {
    const Table table = given.open_table("parameter");
    std::vector<std::string> known{"value", "smallest", "above", "largest", "scale", "summary"};
    if (learnable) known.emplace_back("learnable");
    table.check_keys(known, learnable ? "a parameter" : "an input");
    const auto value = table.find_parameter("value");
    if (!value) given.fail("has no 'value'; write { value = 3.0, smallest = 0, … }, or the value alone");
    take(*value);
    if (const auto above = table.find_parameter("above")) {
      if (table.find_parameter("smallest")) above->fail("cannot be combined with 'smallest'; remove one of them");
      symbol.smallest = above->number();
      symbol.excludes_smallest = true;
    }
    read_metadata(table, symbol);
    if (const auto is = table.find_parameter("learnable")) symbol.learnable = is->boolean();
    check_bounds(*value, result.value, symbol.unit, symbol.smallest, symbol.largest, symbol.excludes_smallest);
  } else {
    take(given);
  }
  // Of a parameter that is to be learnt, the value to begin with tells its magnitude.
  if (learnable && std::isnan(symbol.scale) && result.value != 0.0) symbol.scale = std::abs(result.value);
  return result;
}

std::vector<FormulaState> read_states(const Value& given) {
  const Table table = given.open_table("states");
  std::vector<FormulaState> states;
  for (const std::string& name : table.keys()) states.push_back(read_state(name, *table.find_parameter(name)));
  return states;
}

}  // namespace springnet::scene
