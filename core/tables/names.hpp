// Surfaces by the names that tables give them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

namespace springnet::tables {

// The name of a surface; its number if it has none.
[[nodiscard]] std::string label_of(const Simulation& simulation, std::size_t surface);
// "floor;wall"
[[nodiscard]] std::string labels_of(const Simulation& simulation, const std::vector<std::size_t>& surfaces);

// Length of each surface's label as a cell, in characters.
[[nodiscard]] std::vector<double> label_lengths(const Network& network);

[[nodiscard]] inline std::size_t surface_count(const Network& network) {
  return network.planes().size() + network.instruments().size();
}

// "12 13; 7 8 9": the nodes of the first of two parts of bodies, then those of the second.
[[nodiscard]] std::string pair_of(const std::array<std::uint32_t, 4>& nodes, std::size_t first, std::size_t count);

}  // namespace springnet::tables
