// One constraint of the motion: the velocity of a node, or of one node relative to another, has no component along a
// direction.
#pragma once

#include <cstdint>

#include <springnet/network.hpp>

namespace springnet {

struct ConstraintRow {
  static constexpr std::uint32_t no_node = 0xffffffffu;
  std::uint32_t first;
  std::uint32_t second;       // no_node: the constraint binds the first alone
  Vector3 direction;          // unit, of the first; the second has the opposite
  std::int32_t surface = -1;  // of the obstacle that `first` slides on; -1: a rigid connection
};

}  // namespace springnet
