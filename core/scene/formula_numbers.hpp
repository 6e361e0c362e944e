// Parameters, inputs and states of a formula, with what a scene says of them: 3.0, "3 N/m", or a table with bounds.
#pragma once

#include <string>
#include <vector>

#include <springnet/formula.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

// A parameter or an input with the value that the scene gives.
struct NumberOfFormula {
  FormulaSymbol symbol;
  double value;
};

// { value = "3 N/m", smallest = 0, largest = 100, scale = 10, learnable = true, summary = "…" }, or the value alone.
// Fails at the value if it is out of the bounds. learnable: whether the table may say that it is not.
[[nodiscard]] NumberOfFormula read_number(const std::string& name, const Value& given, bool learnable);

// { z = { rate = "…", start = 0.0, unit = "m", smallest = 0, largest = 1, scale = 1, summary = "…" } }
[[nodiscard]] std::vector<FormulaState> read_states(const Value& given);

}  // namespace springnet::scene
