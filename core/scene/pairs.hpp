// Pairs of nodes to join: listed, or found by how near they are.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

using Pair = std::pair<NodeIndex, NodeIndex>;

// How many pairs a table may find by `within`, and why. Listed and nearest ones are no more than what lists them.
struct PairLimit {
  std::size_t most;
  std::string reason;  // "a scene makes at most 10,000,000 springs this way"
};
using LimitOf = std::function<PairLimit(std::size_t from, std::size_t to)>;  // numbers of nodes selected

// What the keys `pairs`, or `from` and `to` with `within` or `nearest`, of a table say. Throws Error(input) for none,
// and for more than the limit as soon as there are.
[[nodiscard]] std::vector<Pair> find_pairs(const Table& table, const Network& network, const LimitOf& limit);

}  // namespace springnet::scene
