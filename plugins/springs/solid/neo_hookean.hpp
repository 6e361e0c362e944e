// The compressible neo-Hookean material of `solid`, which is the matrix of `fibre_solid`, too. Per volume at rest, with
// I1 = tr C and J = V / V0 (signed),
//   W = mu/2 (I1 - 3) - mu (J - 1) + kappa/2 (J - 1)^2,   mu = E / (2 (1 + nu)),  kappa = mu / (1 - 2 nu).
// Near rest it is Hooke's law with E and nu. kappa > 0 for every nu in (-1, 1/2), and W is finite for every J, so that
// a tetrahedron that was turned inside out is pushed back.
//
// e: an element over the six edges of a tetrahedron and its volume; modulus and nu: E, Pa, and Poisson's ratio.
#pragma once

#include <springnet/sdk/law.hpp>
#include <springnet/sdk/law/simplex.hpp>

namespace springnet::plugins::neo_hookean {

SPRINGNET_INLINE auto shear_modulus(const auto& modulus, const auto& nu) { return modulus / (2.0 * (1.0 + nu)); }

// W, Pa.
SPRINGNET_INLINE auto energy(const auto& e, const auto& modulus, const auto& nu) {
  const auto rest = sdk::gram<3>(e.reference, e.reference);
  // det R = (6 V0)^2, which keeps its digits in thin tetrahedra.
  const auto trace =
      sdk::contracted(rest.adjugate(), sdk::gram<3>(e.q, e.q)) / (36.0 * e.reference[6] * e.reference[6]);
  const auto j = e.q[6] / e.reference[6] - 1.0;
  return shear_modulus(modulus, nu) * (0.5 * (trace - 3.0) + j * (0.5 * j / (1.0 - 2.0 * nu) - 1.0));
}
// V0 dW/dG by the squares and products of edges, V0 mu/2 R^-1, where det R = (6 V0)^2.
template <class Real>
SPRINGNET_INLINE sdk::Symmetric<Real, 3> by_edges(const sdk::SeveralOf<Real, 7>& e, const Real& mu) {
  return mu / (72.0 * e.reference[6]) * sdk::gram<3>(e.reference, e.reference).adjugate();
}
// V0 dW/dV, Pa.
template <class Real>
SPRINGNET_INLINE Real by_volume(const sdk::SeveralOf<Real, 7>& e, const Real& mu, const Real& nu) {
  const Real j = e.q[6] / e.reference[6] - 1.0;
  return mu * (j / (1.0 - 2.0 * nu) - 1.0);
}

}  // namespace springnet::plugins::neo_hookean
