// Names of units, and what they are made of.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace springnet {

// Exponents of kg, m, s, A, K, mol and cd. Angles have none.
using UnitPowers = std::array<double, 7>;
inline constexpr std::array<std::string_view, 7> base_units{"kg", "m", "s", "A", "K", "mol", "cd"};

struct NamedUnit {
  std::string_view name;
  UnitPowers powers;
};
// Those of the SI, without prefixes.
inline constexpr NamedUnit si_units[] = {
    {"kg", {1}},
    {"m", {0, 1}},
    {"s", {0, 0, 1}},
    {"A", {0, 0, 0, 1}},
    {"K", {0, 0, 0, 0, 1}},
    {"mol", {0, 0, 0, 0, 0, 1}},
    {"cd", {0, 0, 0, 0, 0, 0, 1}},
    {"rad", {}},
    {"sr", {}},
    {"N", {1, 1, -2}},
    {"Pa", {1, -1, -2}},
    {"J", {1, 2, -2}},
    {"W", {1, 2, -3}},
    {"Hz", {0, 0, -1}},
    {"C", {0, 0, 1, 1}},
    {"V", {1, 2, -3, -1}},
    {"F", {-1, -2, 4, 2}},
    {"ohm", {1, 2, -3, -2}},
    {"Wb", {1, 2, -2, -1}},
    {"T", {1, 0, -2, -1}},
    {"H", {1, 2, -2, -2}},
    {"lm", {0, 0, 0, 0, 0, 0, 1}},
    {"lx", {0, -2, 0, 0, 0, 0, 1}},
    {"Bq", {0, 0, -1}},
    {"Gy", {0, 2, -2}},
    {"Sv", {0, 2, -2}},
};

// Null for a name that is none of theirs.
[[nodiscard]] constexpr const NamedUnit* find_unit(std::string_view name) {
  const auto* const found = std::find_if(std::begin(si_units), std::end(si_units),
                                         [name](const NamedUnit& each) { return each.name == name; });
  return found == std::end(si_units) ? nullptr : found;
}

}  // namespace springnet
