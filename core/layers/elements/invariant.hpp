// The invariants of elements of three or four nodes: values, rates, gradients and Hessians.
//
// Where the gradient of an invariant is undefined it is zero, so that the element exerts no force: coincident points,
// an angle of exactly 0 or pi that is not bending, a triangle or a wing of a hinge without area. The bending stiffness
// of a straight chain is kept in the linearisation (BentDirections).
#pragma once

#include <cstddef>
#include <cstdint>

#include <springnet/network.hpp>

#include "layers/block.hpp"
#include "layers/kernels.hpp"
#include "network/corners.hpp"

namespace springnet::layers {

inline constexpr std::size_t max_corners = 4;

struct Corners {
  Vector3 position[max_corners];  // m
  Vector3 velocity[max_corners];  // m/s
};
void gather(const std::uint32_t* corners, std::size_t count, const NodeArrays& nodes, Corners& out) noexcept;

// q, its rate q' = sum dq/dp . v, and dq/dp of each corner. For an angle of exactly 0 or pi that is bending they are
// the limits just after, so that damping acts from the start.
struct FirstOrder {
  double value;
  double rate;
  Vector3 gradient[max_corners];
};
void first_order(Invariant invariant, const Corners& corners, FirstOrder& out) noexcept;
// For an angle without a gradient: fills rate and gradients if it is straight and bending. first_order() has done so;
// for those whose value comes from kernels.
void straighten(const Corners& corners, FirstOrder& out) noexcept;
// The value that laws read: a dihedral angle is shifted by whole turns to be nearest to its reference, so that it jumps
// half a turn away from rest, not where wings that rest folded pass through one another.
[[nodiscard]] double nearest_turn(Invariant invariant, double value, double reference) noexcept;

// d2q / dp_i dp_j and dq'/dp_i = sum_j (d2q / dp_i dp_j) v_j.
struct SecondOrder {
  Block hessian[max_corners][max_corners];
  Vector3 rate_gradient[max_corners];
};
void second_order(Invariant invariant, const Corners& corners, SecondOrder& out) noexcept;

// The same for one corner: its diagonal block of the Hessian, and dq'/dp.
struct OwnSecondOrder {
  Block hessian;
  Vector3 rate_gradient;
};
[[nodiscard]] OwnSecondOrder own_second_order(Invariant invariant, const Corners& corners, std::size_t corner) noexcept;

// An angle next to pi (or 0) is pi - |x| (or |x|), where x = J dp is transverse to the chain, J dp = (da - db) / |u| +-
// (dc - db) / |w|. A law that rests there has the energy Q' |x|^2 / 2: stiffness Q' J^T J and damping Q_u J^T J in
// every transverse direction. row[r][i]: derivative of x along the r-th of two transverse directions with respect to
// the position of corner i.
struct BentDirections {
  Vector3 row[2][3];
};
// Whether the sine of an angle is below 1e-7, where its Hessian loses all digits to cancellation; fills `out` if so.
// False for coincident points.
[[nodiscard]] bool is_straight(Invariant invariant, const Corners& corners, BentDirections& out) noexcept;

}  // namespace springnet::layers
