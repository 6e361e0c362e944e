// Renumbers nodes for locality and divides them into units.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/network.hpp>

namespace springnet::layers {

// Nodes of a tile, which is evaluated at once; units begin at multiples of it.
inline constexpr std::uint32_t tile_nodes = 64;
// Fewest nodes of a unit, except the last one.
inline constexpr std::uint32_t least_unit = 2048;

struct Ordering {
  std::vector<std::uint32_t> user;        // [engine's node] user's node
  std::vector<std::uint32_t> engine;      // [user's node] engine's node
  std::vector<std::uint32_t> unit_start;  // [unit + 1] first node of each unit, then the number of nodes
};

// Nodes keep the user's order unless it spreads springs wider than a compact body needs, and reverse Cuthill-McKee
// halves the distances between joined nodes. Units are ranges of the order, so long that nearly all springs lead to the
// same or the next unit; they depend on the network alone, never on the number of threads.
[[nodiscard]] Ordering order_nodes(const Network& network, bool renumber);

}  // namespace springnet::layers
