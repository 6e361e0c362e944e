// The sum over the springs of one node, in one order wherever a single node is evaluated.
#pragma once

#include <algorithm>
#include <cstddef>

#include "layers/laws.hpp"

namespace springnet::layers {

// Springs of a node are summed by so many, counted from the first of their laws: the axial forces, then the others.
inline constexpr std::size_t node_chunk = 64;

// Two numbers side by side, at any address.
using Pair = double __attribute__((vector_size(16)));
using PairInMemory = double __attribute__((vector_size(16), aligned(8), may_alias));
inline Pair pair_at(const double* values) noexcept { return *reinterpret_cast<const PairInMemory*>(values); }
inline void store(Pair pair, double* values) noexcept { *reinterpret_cast<PairInMemory*>(values) = pair; }

// Subtracts tension * n of springs [begin, end) of one node, which have the same laws, from the force on it, N. Springs
// with even and with odd places are summed apart, counted from `begin`: the two sums of a component share a register.
inline void subtract_springs(std::size_t begin, std::size_t end, const double* tension, const double* x,
                             const double* y, const double* z, double& force_x, double& force_y, double& force_z) {
  for (; begin < end; begin += node_chunk) {
    const std::size_t stop = std::min(end, begin + node_chunk);
    Pair sum_x{}, sum_y{}, sum_z{};
    std::size_t i = begin;
    for (; i + 1 < stop; i += 2) {
      const Pair t = pair_at(tension + i);
      sum_x += t * pair_at(x + i);
      sum_y += t * pair_at(y + i);
      sum_z += t * pair_at(z + i);
    }
    if (i < stop) {
      sum_x[0] += tension[i] * x[i];
      sum_y[0] += tension[i] * y[i];
      sum_z[0] += tension[i] * z[i];
    }
    force_x -= sum_x[0] + sum_x[1];
    force_y -= sum_y[0] + sum_y[1];
    force_z -= sum_z[0] + sum_z[1];
  }
}

// Forces, N, [count], of those laws of a group that act along the springs, or along relative velocities: in `first`,
// which takes the sum of two, or in `second`; null: there are none.
inline const double* sum_of_laws(const Group& group, bool relative, double* __restrict first,
                                 const double* __restrict second, std::size_t count) noexcept {
  const bool has_first = group.spring && group.spring.relative == relative;
  const bool has_second = group.viscosity && group.viscosity.relative == relative;
  if (!has_first) return has_second ? second : nullptr;
  if (has_second)
    for (std::size_t i = 0; i < count; ++i) first[i] += second[i];
  return first;
}

}  // namespace springnet::layers
