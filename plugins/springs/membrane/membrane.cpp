// A triangle of an elastic membrane under plane stress, of thickness t and area A0 at rest. C: the Cauchy-Green tensor
// in its plane, E = (C - 1) / 2.
//   st_venant_kirchhoff: W = t A0 Y / (2 (1 - nu^2)) (nu (tr E)^2 + (1 - nu) E : E)
//   neo_hookean: the material of `solid` with the stretch of the thickness, z, for which the stress across vanishes,
//     W = t A0 min over z of mu/2 (tr C + z^2 - 3) - mu (j z - 1) + kappa/2 (j z - 1)^2,   j = A / A0,
//     which is at z = j (mu + kappa) / (mu + kappa j^2); kappa = mu / (1 - 2 nu).
#include <springnet/sdk/law.hpp>
#include <springnet/sdk/law/simplex.hpp>

namespace {
using namespace springnet::sdk;

struct Membrane : SpringFunction {
  enum { youngs_modulus, poisson_ratio, thickness, model };
  using has = Has<Energy>;
  static constexpr const char* id = "membrane";
  static constexpr const char* summary = "triangle of a membrane under plane stress";
  static constexpr const char* reference =
      "P. G. Ciarlet, Mathematical Elasticity III, 2000 (st_venant_kirchhoff); springnet's solid (neo_hookean)";
  static constexpr Shape shape = Shape::triangle;
  static constexpr Scalar invariants[] = {SPRINGNET_TRIANGLE_EDGES};
  static constexpr Parameter parameters[] = {
      number("youngs_modulus", "Pa", "Young's modulus at rest").at_least(0).learnable(),
      number("poisson_ratio", "1", "Poisson's ratio at rest").above(-1).below(0.5).learnable(0.1),
      number("thickness", "m", "at rest").above(0).learnable(),
      choice("model", {"neo_hookean", "st_venant_kirchhoff"}, "how it goes on at large strains")};

  template <class Real>
  static Real energy(const SeveralOf<Real, 3>& e, const Parameters<Real>& p) {
    const Symmetric<Real, 2> rest = gram<2>(e.reference, e.reference), now = gram<2>(e.q, e.q);
    const Real square = rest.determinant();  // (2 A0)^2
    const Real volume = 0.5 * sqrt(square) * p[thickness], nu = p[poisson_ratio];
    const Symmetric<Real, 2> inverse = rest.adjugate();
    if (p[model] > 0.5) {
      // E is similar to R^-1 (G - R) / 2.
      const Symmetric<Real, 2> change = now - rest;
      const Real trace = contracted(inverse, change) / (2.0 * square);
      const Real determinant = change.determinant() / (4.0 * square);
      return volume * p[youngs_modulus] / (2.0 * (1.0 - nu * nu)) *
             (trace * trace - 2.0 * (1.0 - nu) * determinant);  // E : E = (tr E)^2 - 2 det E
    }
    const Real mu = p[youngs_modulus] / (2.0 * (1.0 + nu)), trace = contracted(inverse, now) / square;
    const Real kappa = 1.0 / (1.0 - 2.0 * nu), j2 = now.determinant() / square;  // kappa over mu
    // The minimum over z: with j z - 1 = (j^2 - 1) / (1 + kappa j^2) = y, without the difference of two numbers near 1
    // that kappa would amplify.
    const Real y = (j2 - 1.0) / (1.0 + kappa * j2), z = (1.0 + kappa) / (1.0 + kappa * j2);  // over j
    return volume * mu * (0.5 * (trace + j2 * z * z - 3.0) - y + 0.5 * kappa * y * y);
  }

  template <class Real>
  static std::array<Real, 3> force(const SeveralOf<Real, 3>& e, const Parameters<Real>& p) {
    const Symmetric<Real, 2> rest = gram<2>(e.reference, e.reference), now = gram<2>(e.q, e.q);
    const Real square = rest.determinant(), per_square = 1.0 / square, nu = p[poisson_ratio];
    const Real volume = 0.5 * sqrt(square) * p[thickness];
    const Symmetric<Real, 2> inverse = rest.adjugate();
    // dW/dG = by_trace R^-1 + by_determinant adj(G), or adj(G - R), both over det R. Both models without a branch,
    // which would keep the loop over elements from being vectorised.
    const Real plain = p[model], other = 1.0 - plain;  // 0 and 1, or 1 and 0
    const Symmetric<Real, 2> own = now - plain * rest;
    const Real hooke = 0.5 * volume * p[youngs_modulus] / (1.0 + nu), mu = other * hooke,
               kappa = 1.0 / (1.0 - 2.0 * nu);
    const Real factor = 0.5 * plain * hooke / (1.0 - nu);
    const Real by_trace = factor * contracted(inverse, own) * per_square + 0.5 * mu;
    // At the minimum dW/dj^2 = (-mu + kappa (j z - 1)) z / (2 j), with j z - 1 as in the energy.
    const Real j2 = now.determinant() * per_square, below = 1.0 / (1.0 + kappa * j2);
    const Real by_determinant = 0.5 * (mu * (1.0 + kappa) * below * (kappa * (j2 - 1.0) * below - 1.0) - plain * hooke);
    const Symmetric<Real, 2> stress = per_square * (by_trace * inverse + by_determinant * own.adjugate());
    std::array<Real, 3> result{};
    add_edge_forces(stress, e.q, result.data());
    return result;
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.membrane", "0.1.0", "springnet", "MIT", Membrane);
