// Numbers of nodes and surfaces before a network was extended: take_over() of a part of the engine gets from the same
// part, made of the network before, what has happened since the start.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springnet::layers {

struct NumbersBefore {
  static constexpr std::uint32_t none = 0xffffffffu;
  std::vector<std::uint32_t> node;       // [engine's node] its number before, or none: it is new
  std::vector<std::size_t> surface_now;  // [surface before]

  [[nodiscard]] std::int32_t surface(std::int32_t before) const {
    return before < 0 ? before : static_cast<std::int32_t>(surface_now[static_cast<std::size_t>(before)]);
  }
  // what(node, its number before) for those that are not new.
  template <class What>
  void for_each_node(const What& what) const {
    for (std::uint32_t k = 0; k < node.size(); ++k)
      if (node[k] != none) what(k, node[k]);
  }
};

}  // namespace springnet::layers
