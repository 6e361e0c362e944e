// Sets of nodes that may be updated at once: no two of a set read each other's outputs. Nodes that rigid connections
// join are in one set, because they are updated together.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/plugin.h>

namespace springnet::recurrent {

class Colouring {
 public:
  // Greedy, in the order of the user's numbers, so that it does not depend on the engine's.
  void attach(const springnet_network& network);

  // All nodes, colour by colour, by rising number within one; [colours + 1] places in it where colours begin.
  [[nodiscard]] const std::vector<std::uint32_t>& order() const noexcept { return order_; }
  [[nodiscard]] const std::vector<std::uint32_t>& set_start() const noexcept { return set_start_; }

 private:
  std::vector<std::uint32_t> order_, set_start_;
};

}  // namespace springnet::recurrent
