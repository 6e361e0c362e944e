// One constraint of the motion: the velocity of a node, of one node relative to another, or of the closest points of a
// pair of bodies in contact, has no component along a direction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <springnet/network.hpp>

namespace springnet {

struct ConstraintRow {
  static constexpr std::uint32_t no_node = 0xffffffffu;
  std::uint32_t first;
  std::uint32_t second;       // no_node: the constraint binds the first alone
  Vector3 direction;          // unit, of the first; the second has the opposite
  std::int32_t surface = -1;  // of the obstacle that `first` slides on; -1: a rigid connection, or a pair
  // Of a pair: its other nodes, and what the velocity of each counts. Else 1 and -1.
  std::uint32_t third = no_node, fourth = no_node;
  std::array<double, 4> weights{1.0, -1.0, 0.0, 0.0};
  bool is_pair = false;

  static constexpr std::size_t most_ends = 4;
  // use(i, node, weight) for each node, the first to the fourth.
  template <class Use>
  void for_each_end(const Use& use) const {
    const std::array<std::uint32_t, most_ends> nodes{first, second, third, fourth};
    for (std::size_t i = 0; i < most_ends; ++i)
      if (nodes[i] != no_node) use(i, nodes[i], weights[i]);
  }
};

}  // namespace springnet
