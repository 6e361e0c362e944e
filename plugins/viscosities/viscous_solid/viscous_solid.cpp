// Viscous stress of a tetrahedron by the rate of Green's strain, E' = C' / 2, per volume at rest:
//   S = 2 eta E' + (zeta - 2 eta / 3) (tr E') 1,
// which dissipates S : E' >= 0 and does not resist rotation. With `solid` a Kelvin-Voigt material.
#include <springnet/sdk/law.hpp>
#include <springnet/sdk/law/simplex.hpp>

namespace {
using namespace springnet::sdk;

struct ViscousSolid : ViscosityFunction {
  enum { shear_viscosity, bulk_viscosity };
  static constexpr const char* id = "viscous_solid";
  static constexpr const char* summary = "tetrahedron with viscous stresses by the rate of its strain";
  static constexpr const char* reference = "J. Lubliner, Plasticity Theory, 1990, 1.5 (Kelvin model)";
  static constexpr Shape shape = Shape::tetrahedron;
  static constexpr Scalar invariants[] = {SPRINGNET_TETRAHEDRON_EDGES, at_rest(volume_of(0, 1, 2, 3))};
  static constexpr Parameter parameters[] = {
      number("shear_viscosity", "Pa s", "eta").at_least(0).learnable(),
      number("bulk_viscosity", "Pa s", "zeta, at changes of volume").preset(0).at_least(0).learnable(1)};

  template <class Real>
  static std::array<Real, 7> force(const SeveralOf<Real, 7>& e, const Parameters<Real>& p) {
    const Symmetric<Real, 3> rest = gram<3>(e.reference, e.reference);
    const Symmetric<Real, 3> inverse = 1.0 / (36.0 * e.reference[6] * e.reference[6]) * rest.adjugate();
    const Symmetric<Real, 3> rate = gram<3>(e.q, e.rate);  // G' / 2
    const Real trace = contracted(inverse, rate), lambda = p[bulk_viscosity] - 2.0 / 3.0 * p[shear_viscosity];
    // S : E' with E' similar to R^-1 G' / 2: half of S, by G'.
    const Real by_rate = e.reference[6] * p[shear_viscosity], by_trace = 0.5 * e.reference[6] * lambda * trace;
    const Symmetric<Real, 3> stress = by_rate * sandwich(inverse, rate) + by_trace * inverse;
    std::array<Real, 7> result{};
    add_edge_forces(stress, e.q, result.data());
    return result;
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.viscosity.viscous_solid", "0.1.0", "springnet", "MIT", ViscousSolid);
