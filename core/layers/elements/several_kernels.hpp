// Inner loops over a batch of elements whose laws read several scalars. Compiled once for each instruction set.
#pragma once

#include <cstddef>

#include "layers/elements/kernels.hpp"
#include "layers/elements/scalars.hpp"

namespace springnet::layers {

// Elements that kernels take at once: as many as the widest vectors have numbers.
inline constexpr std::size_t several_at_once = 8;
// Most elements of such a batch, a multiple of that.
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

// The following are of several_at_once members, so that they stay in the nearest cache.
// What a scalar adds to the derivatives beyond its gradient: dq_i'/dp, by corners of the scalar.
struct alignas(64) SeveralRateGradients {
  double value[max_scalars][12][several_at_once];
};

// -dF/dp and -dF/dv of the forces on corners: [corner][other][3 row + column][member].
struct alignas(64) SeveralBlocks {
  double stiffness[4][4][9][several_at_once];
  double damping[4][4][9][several_at_once];  // written if the tangent has rates
};

// The same of each member: [member][block by corner and other, those that the element has][3 row + column].
struct alignas(64) SeveralSpread {
  double entries[several_at_once][4 * 4 * 9];
};

struct SeveralKernels {
  // references: [scalar] of the members; rates: whether rates are wanted.
  void (*geometry)(const ScalarList& list, const BatchCorners& corners, const double* const* references,
                   const NodeArrays& nodes, bool rates, SeveralGeometry& out);
  // -sum_i (Q_i of the first law + Q_i of the second) dq_i/dp on each corner. q: [law][scalar]; null: not read, 0.
  void (*forces)(const ScalarList& list, const SeveralGeometry& geometry, std::size_t count,
                 const double* const (*q)[max_scalars], const CornerForces& out);
  // out: the first plus the second, of which either may be null, or both: 0. False: one is not finite.
  bool (*sum)(const double* first, const double* second, std::size_t count, double* out);
  // Of eight members from `begin` on: Hessians of lengths and volumes times Q_i, and all products of gradients.
  // rate_gradients: those of measures other than these must be there, if the tangent has rates; the kernel fills in
  // lengths and volumes.
  void (*blocks)(const ScalarList& list, const SeveralGeometry& geometry, std::size_t begin,
                 const SeveralTangent& tangent, SeveralRateGradients& rate_gradients, SeveralBlocks& out);
  // blocks: SeveralBlocks::stiffness or damping.
  void (*spread)(const double (*blocks)[4][9][several_at_once], std::size_t corners, SeveralSpread& out);
};

}  // namespace springnet::layers
