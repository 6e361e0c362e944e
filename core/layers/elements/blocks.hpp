// Generalised force of one element of three or four nodes, and the derivative blocks of the forces on its corners.
#pragma once

#include <cmath>

#include "layers/elements/invariant.hpp"
#include "layers/law_pair.hpp"

namespace springnet::layers {

// Generalised force of an element's laws and its derivatives, summed over both.
struct ElementForce {
  double force = 0.0;    // Q: N for a length, N m for an angle, N/m for an area, Pa for a volume
  double by_q = 0.0;     // dQ/dq
  double by_rate = 0.0;  // dQ/dq'

  [[nodiscard]] bool is_finite() const noexcept {
    return std::isfinite(force) && std::isfinite(by_q) && std::isfinite(by_rate);
  }
};
// Sum of what the laws answered for member i of a batch of elements, with derivatives or without.
template <std::size_t capacity>
[[nodiscard]] ElementForce element_force(const Group& group, const PairAnswers<capacity>& answers, std::size_t i,
                                         bool derivatives) {
  ElementForce sum;
  const std::array<const Law*, 2> laws = group.laws();
  for (std::size_t k = 0; k < laws.size(); ++k) {
    if (!*laws[k]) continue;
    sum.force += answers.force[k][i];
    if (!derivatives) continue;
    sum.by_q += answers.by_q[k][i];
    sum.by_rate += answers.by_rate[k][i];
  }
  return sum;
}

// With F_i = -Q dq/dp_i the force on corner i:
//   -dF_i/dp_j = Q d2q/dp_i dp_j + dq/dp_i (Q_q dq/dp_j + Q_u dq'/dp_j)^T
//   -dF_i/dv_j = Q_u dq/dp_i dq/dp_j^T, or, for a straight angle, its sum over both rows in place of dq/dp.
struct ElementBlocks {
  Block stiffness[max_corners][max_corners];
  Vector3 row[2][max_corners];  // the second is zero except for a straight angle
  double damping;               // Q_u

  [[nodiscard]] Block damping_block(std::size_t i, std::size_t j) const {
    return damping * (row[0][i] * row[0][j].transpose() + row[1][i] * row[1][j].transpose());
  }
};
void linearise(Invariant invariant, const Corners& corners, const FirstOrder& geometry, const ElementForce& law,
               ElementBlocks& out) noexcept;
// Diagonal blocks of one corner alone.
void linearise_own(Invariant invariant, const Corners& corners, const FirstOrder& geometry, const ElementForce& law,
                   std::size_t corner, Block& stiffness, Block& damping) noexcept;

}  // namespace springnet::layers
