// A formula as C++ of the plugin SDK: what `springnet plugin new` writes for `--formula` and `--from`.
#pragma once

#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/formula.hpp>

namespace springnet {

// A function of a law's class: `static auto NAME(const auto& e, const auto& p) { statements }`.
struct SourceFunction {
  std::string name;  // "force", "energy", "margin", "state_rates"
  std::vector<std::string> statements;
  bool uses_element = false, uses_parameters = false;  // whether the statements name e and p
};

// A list of the class: `static constexpr TYPE NAME[] = {ENTRIES};`.
struct SourceList {
  std::string type, name;  // "Parameter", "parameters"
  std::vector<std::string> entries;
};

// The parts of a law's class. The compiled law has the bits of the formula, its bounds and what it declares.
struct FormulaSource {
  std::vector<std::string> parameters;          // their names in scenes, in the order in which the formula has them
  std::vector<std::string> enumerators;         // their names in C++
  std::vector<std::vector<std::string>> enums;  // one for each list of names in C++: parameters, states, …
  std::vector<std::string> declarations;        // "static constexpr bool reads_time = true;", "using has = …;"
  std::vector<SourceList> lists;
  std::string prepare;       // of a law with curves: the function that makes them of its tables; else empty
  bool uses_tables = false;  // whether the class needs springnet/sdk/table.hpp
  std::vector<SourceFunction> functions;
  // The keys of scenes for the points of each curve of the formula, x and y: tables of the plugin.
  std::vector<std::string> table_keys;
};

// Parameters that the law does not list are those of parameters_of(). Throws Error(input) as component_of() does, and
// for names that a plugin cannot have.
[[nodiscard]] SPRINGNET_API FormulaSource source_of(const LawFormula& formula);

}  // namespace springnet
