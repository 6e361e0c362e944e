// A formula as C++ of the plugin SDK: what `springnet plugin new --formula` writes.
#pragma once

#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/formula.hpp>

namespace springnet {

// The parts of a law's class. The compiled law has the bits of the formula.
struct FormulaSource {
  std::vector<std::string> parameters;    // their names in scenes, in the order in which the formula has them
  std::vector<std::string> enumerators;   // their names in C++
  std::vector<std::string> declarations;  // "static constexpr bool reads_time = true;"
  std::vector<std::string> statements;    // of force(e, p)
  bool uses_element = false, uses_parameters = false;  // whether the statements name e and p
};

// Of a law with a force over one length, or over the relative speed. Parameters that the law does not list are those of
// parameters_of(). Throws Error(input) as component_of() does, and for what a plugin has to declare in another way: an
// energy, a margin, inputs, states, curves, several scalars, angles, areas and volumes.
[[nodiscard]] SPRINGNET_API FormulaSource source_of(const LawFormula& formula);

}  // namespace springnet
