// Laws as formulas: { formula = "stiffness * e", stiffness = 3.0 }.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "scene/files.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {

// A parameter that a formula may name and that stands elsewhere, in the material of the body.
struct MaterialParameter {
  std::string name, unit;
  std::function<double()> value;  // called if a formula of the law names it
};

// Whether the table of a law has a formula, or an energy, in place of the name of a law.
[[nodiscard]] bool is_formula_of(const Table& table);
// Whether such a table has the key for another purpose than a parameter: "formula", "states".
[[nodiscard]] bool is_key_of_formulas(std::string_view key);
// The shape of the elements that a formula over several scalars is for, by the nodes that these have: triangles,
// tetrahedra, or hinges. Nothing: it reads one value.
[[nodiscard]] std::optional<Invariant> shape_of_formula(const Table& table);
// Keys that are none of the language's are parameters: numbers, texts with a unit, "3 N/m", or tables with bounds.
// `elements`: of which invariant those are that have the law; nothing: springs. Notes the law in `files` if that asks
// for it.
[[nodiscard]] LawUse read_formula(const Table& table, ComponentKind kind, const Files& files,
                                  std::optional<Invariant> elements, const std::vector<MaterialParameter>& given = {});

}  // namespace springnet::scene
