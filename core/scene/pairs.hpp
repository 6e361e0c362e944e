// Pairs of nodes to join: listed, or found by how near they are.
#pragma once

#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

using Pair = std::pair<NodeIndex, NodeIndex>;

// What the keys `pairs`, or `from` and `to` with `within` or `nearest`, of a table say. Throws Error(input) for none.
[[nodiscard]] std::vector<Pair> find_pairs(const Table& table, const Network& network);

}  // namespace springnet::scene
