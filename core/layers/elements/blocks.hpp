// What one element of three or four nodes contributes to the derivatives of the forces on its corners.
#pragma once

#include "layers/elements/invariant.hpp"

namespace springnet::layers {

// What laws answer for an element, Q summed over both of them, and its derivatives.
struct ElementForce {
  double force = 0.0;    // Q
  double by_q = 0.0;     // dQ/dq
  double by_rate = 0.0;  // dQ/dq'
};

// With F_i = -Q dq/dp_i the force on corner i:
//   -dF_i/dp_j = Q d2q/dp_i dp_j + dq/dp_i (Q_q dq/dp_j + Q_u dq'/dp_j)^T
//   -dF_i/dv_j = Q_u dq/dp_i dq/dp_j^T, or the sum over two rows in place of dq/dp where an angle is straight.
struct ElementBlocks {
  Block stiffness[most_corners][most_corners];
  Vector3 row[2][most_corners];  // the second is zero but for a straight angle
  double damping;                // Q_u

  [[nodiscard]] Block damping_block(std::size_t i, std::size_t j) const {
    return damping * (row[0][i] * row[0][j].transpose() + row[1][i] * row[1][j].transpose());
  }
};
void linearise(Invariant invariant, const Corners& corners, const FirstOrder& geometry, const ElementForce& law,
               ElementBlocks& out) noexcept;
// The same of one corner alone.
void linearise_own(Invariant invariant, const Corners& corners, const FirstOrder& geometry, const ElementForce& law,
                   std::size_t corner, Block& stiffness, Block& damping) noexcept;

}  // namespace springnet::layers
