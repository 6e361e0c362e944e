// The sum over the springs of one node, in one order wherever a single node is evaluated.
#pragma once

#include <algorithm>
#include <cstddef>

namespace springnet::layers {

// Springs of a node are summed by so many, counted from the first of their laws.
inline constexpr std::size_t node_chunk = 64;

// Subtracts tension * n of springs [begin, end) of one node, which have the same laws, from the force on it, N. Two
// chains, of springs with even and with odd places, hide half of the time that a sum takes.
inline void subtract_springs(std::size_t begin, std::size_t end, const double* tension, const double* x,
                             const double* y, const double* z, double& force_x, double& force_y, double& force_z) {
  for (; begin < end; begin += node_chunk) {
    const std::size_t stop = std::min(end, begin + node_chunk);
    double even[3] = {0.0, 0.0, 0.0}, odd[3] = {0.0, 0.0, 0.0};
    std::size_t i = begin;
    for (; i + 1 < stop; i += 2) {
      even[0] += tension[i] * x[i];
      even[1] += tension[i] * y[i];
      even[2] += tension[i] * z[i];
      odd[0] += tension[i + 1] * x[i + 1];
      odd[1] += tension[i + 1] * y[i + 1];
      odd[2] += tension[i + 1] * z[i + 1];
    }
    if (i < stop) {
      even[0] += tension[i] * x[i];
      even[1] += tension[i] * y[i];
      even[2] += tension[i] * z[i];
    }
    force_x -= even[0] + odd[0];
    force_y -= even[1] + odd[1];
    force_z -= even[2] + odd[2];
  }
}

}  // namespace springnet::layers
