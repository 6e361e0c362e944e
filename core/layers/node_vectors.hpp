// One node's vectors of those that layers read.
#pragma once

#include <cstdint>

#include <springnet/network.hpp>

#include "layers/kernels.hpp"

namespace springnet::layers {

[[nodiscard]] inline Vector3 position_of(const NodeArrays& nodes, std::uint32_t k) {
  return {nodes.px[k], nodes.py[k], nodes.pz[k]};
}
[[nodiscard]] inline Vector3 velocity_of(const NodeArrays& nodes, std::uint32_t k) {
  return {nodes.vx[k], nodes.vy[k], nodes.vz[k]};
}

}  // namespace springnet::layers
