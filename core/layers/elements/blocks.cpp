#include "layers/elements/blocks.hpp"

namespace springnet::layers {

void linearise(Invariant invariant, const Corners& corners, const FirstOrder& geometry, const ElementForce& law,
               ElementBlocks& out) noexcept {
  const std::size_t count = corners_of(invariant);
  out.damping = law.by_rate;
  BentDirections bent;
  if (is_straight(invariant, corners, bent)) {
    for (std::size_t i = 0; i < count; ++i) {
      for (int r = 0; r < 2; ++r) out.row[r][i] = bent.row[r][i];
      for (std::size_t j = 0; j < count; ++j)
        out.stiffness[i][j] =
            law.by_q * (bent.row[0][i] * bent.row[0][j].transpose() + bent.row[1][i] * bent.row[1][j].transpose());
    }
    return;
  }
  SecondOrder second;
  second_order(invariant, corners, second);
  for (std::size_t i = 0; i < count; ++i) {
    out.row[0][i] = geometry.gradient[i];
    out.row[1][i].setZero();
    for (std::size_t j = 0; j < count; ++j) {
      const Vector3 change = law.by_q * geometry.gradient[j] + law.by_rate * second.rate_gradient[j];
      out.stiffness[i][j] = law.force * second.hessian[i][j] + geometry.gradient[i] * change.transpose();
    }
  }
}

void linearise_own(Invariant invariant, const Corners& corners, const FirstOrder& geometry, const ElementForce& law,
                   std::size_t corner, Block& stiffness, Block& damping) noexcept {
  BentDirections bent;
  if (is_straight(invariant, corners, bent)) {
    const Block square =
        bent.row[0][corner] * bent.row[0][corner].transpose() + bent.row[1][corner] * bent.row[1][corner].transpose();
    stiffness = law.by_q * square;
    damping = law.by_rate * square;
    return;
  }
  const OwnSecondOrder second = own_second_order(invariant, corners, corner);
  const Vector3& g = geometry.gradient[corner];
  const Vector3 change = law.by_q * g + law.by_rate * second.rate_gradient;
  stiffness = law.force * second.hessian + g * change.transpose();
  damping = law.by_rate * g * g.transpose();
}

}  // namespace springnet::layers
