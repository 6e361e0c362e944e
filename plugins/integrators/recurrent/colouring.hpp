// Sets of nodes that can be updated in parallel: no two nodes of a set read each other's outputs. Rigidly connected
// nodes are in the same set, because they are updated together.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/plugin.h>

namespace springnet::recurrent {

class Colouring {
 public:
  // Greedy colouring in the order of the user's numbers, so that it does not depend on the engine's.
  void attach(const springnet_network& network);

  // order(): all nodes, colour by colour, in ascending order within each. set_start(): [colours + 1] where they begin.
  [[nodiscard]] const std::vector<std::uint32_t>& order() const noexcept { return order_; }
  [[nodiscard]] const std::vector<std::uint32_t>& set_start() const noexcept { return set_start_; }

 private:
  std::vector<std::uint32_t> order_, set_start_;
};

}  // namespace springnet::recurrent
