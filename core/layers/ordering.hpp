// Renumbers nodes for locality and divides them into units.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/network.hpp>

namespace springnet::layers {

// Most nodes of a unit. The units depend on the network alone, never on the number of threads.
inline constexpr std::uint32_t max_unit = 8192;

struct Ordering {
  std::vector<std::uint32_t> user;        // [engine's node] user's node
  std::vector<std::uint32_t> engine;      // [user's node] engine's node
  std::vector<std::uint32_t> unit_start;  // [unit + 1] first node of each unit, then the number of nodes
};

// Units are made by recursive bisection in space, so that few springs cross their boundaries. Within a unit nodes keep
// the user's order unless reverse Cuthill-McKee at least halves the distances between joined nodes. Without renumbering
// units are ranges of the user's order.
[[nodiscard]] Ordering order_nodes(const Network& network, bool renumber);

}  // namespace springnet::layers
