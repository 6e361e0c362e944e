// A direction in which the motion of one node, or of one against another, is bound.
#pragma once

#include <cstdint>

#include <springnet/network.hpp>

namespace springnet {

struct ConstraintRow {
  static constexpr std::uint32_t no_node = 0xffffffffu;
  std::uint32_t first;
  std::uint32_t second;       // no_node: of the first alone
  Vector3 direction;          // at the first, unit; the second has the opposite
  std::int32_t surface = -1;  // that `first` slides on; -1: the row is a rigid connection's
};

}  // namespace springnet
