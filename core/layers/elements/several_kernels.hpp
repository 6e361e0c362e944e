// Inner loops over a batch of elements whose laws read several scalars. Compiled once for each instruction set.
#pragma once

#include <cstddef>

#include "layers/elements/kernels.hpp"
#include "layers/elements/scalars.hpp"

namespace springnet::layers {

// Most elements of such a batch, a multiple of chunk_springs.
inline constexpr std::size_t several_batch = 64;

// Arrays are [scalar][member]; of a scalar that is read at rest alone they are not written. Members beyond the last, up
// to a multiple of eight, have the values of the last.
struct alignas(64) SeveralGeometry {
  double value[max_scalars][several_batch];         // q_i as laws read it
  double rate[max_scalars][several_batch];          // q_i'
  double gradient[max_scalars][12][several_batch];  // dq_i/dp: [3 corner of the scalar + coordinate]
  double position[12][several_batch];               // m, [3 corner of the element + coordinate], less the first corner
  double velocity[12][several_batch];               // m/s, less that of the first corner
};

// Of both laws together: Q_i, dQ_i/dq_j at j + max_scalars i, dQ_i/dq_j'.
struct alignas(64) SeveralTangent {
  double force[max_scalars][several_batch];
  double by_value[max_scalars * max_scalars][several_batch];
  double by_rate[max_scalars * max_scalars][several_batch];
  bool has_rates;
};

// What a scalar adds to the derivatives beyond its gradient: dq_i'/dp, by corners of the scalar.
struct alignas(64) SeveralRateGradients {
  double value[max_scalars][12][several_batch];
};

// -dF/dp and -dF/dv of the forces on corners: [corner][other][3 row + column][member].
struct alignas(64) SeveralBlocks {
  double stiffness[4][4][9][several_batch];
  double damping[4][4][9][several_batch];  // written if the tangent has rates
};

struct SeveralKernels {
  // references: [scalar] of the members; rates: whether rates are wanted.
  void (*geometry)(const ScalarList& list, const BatchCorners& corners, const double* const* references,
                   const NodeArrays& nodes, bool rates, SeveralGeometry& out);
  // -sum_i (Q_i of the first law + Q_i of the second) dq_i/dp on each corner. q: [law][scalar]; null: not read, 0.
  void (*forces)(const ScalarList& list, const SeveralGeometry& geometry, std::size_t count,
                 const double* const (*q)[max_scalars], const CornerForces& out);
  // Hessians of lengths and volumes times Q_i, and all products of gradients. rate_gradients: those of measures other
  // than these must be there, if the tangent has rates; the kernel fills in lengths and volumes.
  void (*blocks)(const ScalarList& list, const SeveralGeometry& geometry, std::size_t count,
                 const SeveralTangent& tangent, SeveralRateGradients& rate_gradients, SeveralBlocks& out);
};

}  // namespace springnet::layers
