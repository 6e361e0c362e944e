// Viscous tension of a triangle by the rate of Green's strain in its plane, E' = C' / 2, per area at rest:
//   N = 2 eta E' + (zeta - eta) (tr E') 1,
// which dissipates N : E' >= 0 and does not resist rotation. With `membrane` a Kelvin-Voigt material.
#include <springnet/sdk/law.hpp>
#include <springnet/sdk/law/simplex.hpp>

namespace {
using namespace springnet::sdk;

struct ViscousMembrane : ViscosityFunction {
  enum { shear_viscosity, area_viscosity };
  static constexpr const char* id = "viscous_membrane";
  static constexpr const char* summary = "triangle with viscous tensions by the rate of its strain";
  static constexpr const char* reference = "J. Lubliner, Plasticity Theory, 1990, 1.5 (Kelvin model), in the plane";
  static constexpr Shape shape = Shape::triangle;
  static constexpr Scalar invariants[] = {SPRINGNET_TRIANGLE_EDGES};
  static constexpr Parameter parameters[] = {
      number("shear_viscosity", "N s/m", "eta, of the surface").at_least(0).learnable(),
      number("area_viscosity", "N s/m", "zeta, at changes of area").preset(0).at_least(0).learnable(1)};

  template <class Real>
  static std::array<Real, 3> force(const SeveralOf<Real, 3>& e, const Parameters<Real>& p) {
    const Symmetric<Real, 2> rest = gram<2>(e.reference, e.reference);
    const Real square = rest.determinant(), area = 0.5 * sqrt(square), per_square = 1.0 / square;
    const Symmetric<Real, 2> inverse = per_square * rest.adjugate();
    const Symmetric<Real, 2> rate = gram<2>(e.q, e.rate);  // G' / 2
    const Real trace = contracted(inverse, rate), lambda = p[area_viscosity] - p[shear_viscosity];
    const Real by_rate = area * p[shear_viscosity], by_trace = 0.5 * area * lambda * trace;
    const Symmetric<Real, 2> stress = by_rate * sandwich(inverse, rate) + by_trace * inverse;
    std::array<Real, 3> result{};
    add_edge_forces(stress, e.q, result.data());
    return result;
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.viscosity.viscous_membrane", "0.1.0", "springnet", "MIT", ViscousMembrane);
