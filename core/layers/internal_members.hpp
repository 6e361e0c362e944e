// The springs and elements with internal state that are there, and their laws.
#pragma once

#include <cstdint>

#include "layers/layout.hpp"

namespace springnet::layers {

// Calls what(law, index of its first state, distance between its states) for each law with states of a member.
template <class What>
void for_each_law_with_states(const Layout& layout, std::size_t group, std::uint32_t place, const What& what) {
  const InternalLayout::OfGroup& own = layout.internal().group(group);
  for (const Law* const law : layout.laws().groups[group].laws())
    if (law->state_count > 0) what(*law, own.first + law->first_state * own.count + place, std::uint64_t{own.count});
}

// Calls what(spring or element, its group, its place) for each.
template <class What>
void for_each_spring_with_states(const Layout& layout, const What& what) {
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    if (!layout.internal().has(g)) continue;
    for (const std::uint32_t s : layout.springs_of(g)) what(s, g, layout.internal().of_spring(s));
  }
}
template <class What>
void for_each_element_with_states(const Layout& layout, const What& what) {
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e) {
    const std::size_t group = layout.elements().group(e);
    if (layout.elements().alive(e) && layout.internal().has(group)) what(e, group, layout.internal().of_element(e));
  }
}

}  // namespace springnet::layers
