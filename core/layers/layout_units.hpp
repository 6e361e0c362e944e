// The units that have a spring, for the sources of Layout's functions.
#pragma once

#include <algorithm>

#include "layers/layout.hpp"
#include "layers/unit_builder.hpp"

namespace springnet::layers {

template <class What>
void Layout::for_units_of(std::uint32_t spring, const What& what) const {
  const std::uint32_t a = std::min(first(spring), second(spring)), b = std::max(first(spring), second(spring));
  const std::uint32_t u = unit_of(a), v = unit_of(b);
  const bool is_far = v > u + 1;
  const std::uint32_t group = laws_.group[spring], row = laws_.row[spring];
  what(u, UnitSpring{a, b, spring, group, row, is_far});
  if (is_far) what(v, UnitSpring{b, a, spring, group, row, true});
}

}  // namespace springnet::layers
