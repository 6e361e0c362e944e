// Forces of bodies in contact on each other, as a page draws them: two arrows at each place, one each way.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

#include "view/selection.hpp"

namespace springnet::view {

// More arrows than those of so many touches are unreadable.
inline constexpr std::size_t max_touches = 100;

// The most touches that a frame has room for: max_touches, or fewer if the network has fewer pairs that could touch; 0
// without contact of bodies.
[[nodiscard]] std::size_t touch_capacity(const Network& network);

// Fills a frame's row, touch_numbers each, with those that have a force, in their order: the place in Selection::nodes
// of one of its nodes that is shown, or -1; x, y, z of where bodies touch, m; x, y, z of the force on the first of
// them, N. If there is not room for all, those with the largest forces are kept, the first of equal ones. Forces that
// are mere rounding beside the largest count as none; the rest of the row has none. Returns how many have a force.
std::size_t take_touches(const std::vector<BodyTouch>& touches, const Selection& selection, std::span<float> row);

}  // namespace springnet::view
