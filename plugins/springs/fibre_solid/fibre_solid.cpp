// A tetrahedron of a matrix as in `solid` with fibres along one direction a. With I4 = a . C a, per volume at rest,
//   W = W_solid + Ef / (8 k) (exp(k x^2) - 1),   x = I4 - 1, or max(x, 0) for fibres that do not push.
// Near rest the fibres add the modulus Ef along a; in the limit k = 0 they have W = Ef x^2 / 8.
#include <springnet/sdk/law.hpp>

#include "../solid/neo_hookean.hpp"

namespace {
using namespace springnet::sdk;
namespace neo_hookean = springnet::plugins::neo_hookean;

struct FibreSolid : SpringFunction {
  enum { youngs_modulus, poisson_ratio, fibre_modulus, fibre_stiffening, fibres_push };
  using has = Has<Energy>;
  static constexpr const char* id = "fibre_solid";
  static constexpr const char* summary = "transversely isotropic tetrahedron: neo-Hookean with fibres in one direction";
  static constexpr const char* reference =
      "G. A. Holzapfel, T. C. Gasser, R. W. Ogden, A new constitutive framework for arterial wall mechanics, J. "
      "Elasticity 61 (2000) 1-48, for one family of fibres";
  static constexpr Shape shape = Shape::tetrahedron;
  static constexpr bool reads_direction = true;
  static constexpr Scalar invariants[] = {SPRINGNET_TETRAHEDRON_EDGES, volume_of(0, 1, 2, 3)};
  static constexpr Parameter parameters[] = {
      number("youngs_modulus", "Pa", "Young's modulus of the matrix").at_least(0).learnable(),
      number("poisson_ratio", "1", "Poisson's ratio of the matrix").above(-1).below(0.5).learnable(0.1),
      number("fibre_modulus", "Pa", "what fibres add to the modulus along them").at_least(0).learnable(),
      number("fibre_stiffening", "1", "how fast fibres stiffen, the exponent k").preset(0).at_least(0).learnable(1),
      boolean("fibres_push", "fibres resist being shortened, too")};

  // The fibres' strain x.
  static auto stretched(const auto& e, const auto& p) {
    const auto g = gram<3>(e.q, e.q);
    const auto& a = e.direction;
    const auto square = a[0] * a[0] * g(0, 0) + a[1] * a[1] * g(1, 1) + a[2] * a[2] * g(2, 2) +
                        2.0 * (a[0] * a[1] * g(0, 1) + a[0] * a[2] * g(0, 2) + a[1] * a[2] * g(1, 2));
    const auto x = square - 1.0;
    return p[fibres_push] > 0.5 ? x : max(x, 0.0);
  }

  static auto energy(const auto& e, const auto& p) {
    const auto x = stretched(e, p);
    const auto k = p[fibre_stiffening];
    // (exp(k x^2) - 1) / k, by its series where k x^2 is small
    const auto y = k * x * x;
    const auto fibres = y > 1e-8 ? expm1(y) / (k > 0.0 ? k : k + 1.0) : x * x * (1.0 + 0.5 * y);
    return e.reference[6] *
           (neo_hookean::energy(e, p[youngs_modulus], p[poisson_ratio]) + 0.125 * p[fibre_modulus] * fibres);
  }

  template <class Real>
  static std::array<Real, 7> force(const SeveralOf<Real, 7>& e, const Parameters<Real>& p) {
    const Real mu = neo_hookean::shear_modulus(p[youngs_modulus], p[poisson_ratio]);
    // V0 dW/dI4 a a^T
    const Real x = stretched(e, p);
    const Real along = 0.25 * e.reference[6] * p[fibre_modulus] * x * exp(p[fibre_stiffening] * x * x);
    const auto& a = e.direction;
    const Symmetric<Real, 3> fibres = {{a[0] * a[0], a[1] * a[1], a[2] * a[2], a[0] * a[1], a[0] * a[2], a[1] * a[2]}};
    std::array<Real, 7> result{};
    add_edge_forces(neo_hookean::by_edges(e, mu) + along * fibres, e.q, result.data());
    result[6] = neo_hookean::by_volume(e, mu, p[poisson_ratio]);
    return result;
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.fibre_solid", "0.1.0", "springnet", "MIT", FibreSolid);
