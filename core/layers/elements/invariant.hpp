// The invariants of elements of three or four nodes: values, rates, gradients and Hessians.
//
// Where an invariant has no direction its gradient is zero, so that no law can push the element: coincident points, an
// angle of exactly 0 or pi that does not move across itself, a triangle or a wing of a hinge without area. What bends a
// chain that is straight is kept in the linearisation (BentDirections).
#pragma once

#include <cstddef>
#include <cstdint>

#include <springnet/network.hpp>

#include "layers/block.hpp"
#include "layers/kernels.hpp"

namespace springnet::layers {

inline constexpr std::size_t most_corners = 4;
// 0 for an enclosed volume, which has as many as its enclosure: enclosure.hpp.
[[nodiscard]] std::size_t corners_of(Invariant invariant) noexcept;

struct Corners {
  Vector3 position[most_corners];  // m
  Vector3 velocity[most_corners];  // m/s
};
void gather(const std::uint32_t* corners, std::size_t count, const NodeArrays& nodes, Corners& out) noexcept;

// q, q' = sum dq/dp . v and dq/dp of each corner. An angle of exactly 0 or pi that bends has those of the next moment,
// so that what damps it acts from the start.
struct FirstOrder {
  double value;
  double rate;
  Vector3 gradient[most_corners];
};
void first_order(Invariant invariant, const Corners& corners, FirstOrder& out) noexcept;
// What a law reads for a value: that of a dihedral angle which is nearest to its reference, whole turns apart, so that
// it jumps where it is half a turn from there and not where wings that rest folded pass through one another.
[[nodiscard]] double nearest_turn(Invariant invariant, double value, double reference) noexcept;

// d2q / dp_i dp_j and dq'/dp_i = sum_j (d2q / dp_i dp_j) v_j.
struct SecondOrder {
  Block hessian[most_corners][most_corners];
  Vector3 rate_gradient[most_corners];
};
void second_order(Invariant invariant, const Corners& corners, SecondOrder& out) noexcept;

// The same of one corner: its own block of the Hessian, and dq'/dp.
struct OwnSecondOrder {
  Block hessian;
  Vector3 rate_gradient;
};
[[nodiscard]] OwnSecondOrder own_second_order(Invariant invariant, const Corners& corners, std::size_t corner) noexcept;

// An angle next to pi (or 0) is pi - |x| (or |x|) with x = J dp across the chain, J dp = (da - db) / |u| +- (dc - db) /
// |w|. With a law that rests there the energy is Q' |x|^2 / 2: stiffness Q' J^T J and damping Q_u J^T J, whatever the
// direction. row[r][i]: derivative of x along the r-th of two directions across, by the position of corner i.
struct BentDirections {
  Vector3 row[2][3];
};
// Whether the sine of an angle is below 1e-7, where the Hessian above loses its digits; then fills `out`. Not for
// coincident points.
[[nodiscard]] bool is_straight(Invariant invariant, const Corners& corners, BentDirections& out) noexcept;

}  // namespace springnet::layers
