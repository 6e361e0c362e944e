// Pairs that touch at the same place: of a corner on a corner all faces and edges that meet there. An impulse on one of
// them does the same as on any other.
#pragma once

#include <cstddef>
#include <vector>

#include "constraints/pair_rows.hpp"

namespace springnet {

// The first of rows whose nodes, weights, direction and friction are the same, to rounding, gets the impulses of all;
// the others are blocked, without one, until that is decided anew. Rows that are blocked or done stay as they are.
// Returns how many were joined with others.
std::size_t join_same(std::vector<PairRow>& rows);

}  // namespace springnet
