// Clusters: nodes that rigid connections join.
#pragma once

#include <cstdint>

namespace springnet {

inline constexpr std::uint32_t no_cluster = 0xffffffffu;  // in place of the number of a node's cluster

}  // namespace springnet
