// Laws as formulas: { formula = "stiffness * e", stiffness = 3.0 }.
#pragma once

#include <optional>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

// Whether the table of a law has a formula, or an energy, in place of the name of a law.
[[nodiscard]] bool is_formula_of(const Table& table);
// Keys that are none of the language's are parameters: numbers, or texts with a unit, "3 N/m". `shape`: that of the
// elements of a law over several scalars.
[[nodiscard]] LawUse read_formula(const Table& table, ComponentKind kind, std::optional<Invariant> shape);

}  // namespace springnet::scene
