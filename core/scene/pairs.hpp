// Pairs of nodes to join: listed, or found by distance.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

using Pair = std::pair<NodeIndex, NodeIndex>;

// How many pairs a table may find by `within`, and why. Listed and nearest pairs need no limit: they are at most as
// many as the entries.
struct PairLimit {
  std::size_t max_pairs;
  std::string reason;  // "a scene makes at most 10,000,000 springs this way"
};
using LimitOf = std::function<PairLimit(std::size_t from, std::size_t to)>;  // numbers of nodes selected

// Pairs given by the key `pairs` of a table, or by `from` and `to` with `within` or `nearest`. Throws Error(input) if
// there are none, or as soon as there are more than the limit.
[[nodiscard]] std::vector<Pair> find_pairs(const Table& table, const Network& network, const LimitOf& limit);

}  // namespace springnet::scene
