// Two nodes as one key, whichever comes first.
#pragma once

#include <algorithm>
#include <cstdint>

#include <springnet/network.hpp>

namespace springnet::view {

[[nodiscard]] inline std::uint64_t pair_of(NodeIndex a, NodeIndex b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32U | std::max(a, b);
}

}  // namespace springnet::view
