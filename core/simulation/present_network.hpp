// The network of a simulation as it is at present.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/network.hpp>

#include "simulation/engine.hpp"

namespace springnet {

// Numbers of springs and elements in the new network; `removed` for those that are not in it.
struct NewNumbers {
  static constexpr std::uint32_t removed = 0xffffffffu;
  std::vector<std::uint32_t> spring, element;
};

// torn: [face of the network]
[[nodiscard]] Network present_network(const Network& network, Engine& engine, const std::vector<std::uint8_t>& torn);

// Adds loads, motions, planes, instruments and cuts as they go on from now.
void add_surroundings(const Network& network, Engine& engine, const NewNumbers& numbers, Network& result);

}  // namespace springnet
