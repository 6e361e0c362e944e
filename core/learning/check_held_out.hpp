// Observations that judge must not be among those that are learned from.
#pragma once

#include <cstddef>

#include <springnet/observations.hpp>

namespace springnet::learning {

// Checks those that are held out as check_observations(), from 0 s to the last time of both. Throws Error(input) with
// both places for a value that is also learned from.
void check_held_out(const Observations& learned_from, const Observations& held_out, std::size_t node_count);

}  // namespace springnet::learning
