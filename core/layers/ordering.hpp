// Renumbering of nodes for locality, and their division into units.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/network.hpp>

namespace springnet::layers {

// Units have at most this many nodes. Their number depends on the network alone, never on the number of threads.
inline constexpr std::uint32_t max_unit = 8192;

struct Ordering {
  std::vector<std::uint32_t> user;        // [engine's node] user's node
  std::vector<std::uint32_t> engine;      // [user's node] engine's node
  std::vector<std::uint32_t> unit_start;  // [unit + 1] nodes of a unit are contiguous
};

// Units by recursive bisection in space, so that few springs cross their boundaries; within a unit the user's order,
// unless reverse Cuthill-McKee at least halves the distance between joined nodes. Without renumbering, units are
// ranges of the user's order.
[[nodiscard]] Ordering order_nodes(const Network& network, bool renumber);

}  // namespace springnet::layers
