// Bending of a thin shell at the edge of two triangles: with the angle theta between their normals, the edge's length l
// and the areas A1, A2 at rest,
//   W = D l^2 / (2 (A1 + A2)) (theta - theta0)^2,   D = E t^3 / (12 (1 - nu^2)).
// For equilateral triangles of any orientation the sum over all edges is, per area, with principal curvatures k1 and
// k2,
//   D/2 (k1^2 + k2^2 - 2/3 k1 k2):
// exactly that of a plate, D/2 k^2, where it is bent about one axis, as a cylinder. What a plate adds for two
// curvatures, D nu k1 k2, it does not follow: that is -D/3 k1 k2 for every nu, which a hinge, with its one angle,
// cannot know. Other triangles have other energies, which depend on the direction of bending.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Shell : SpringFunction {
  enum { youngs_modulus, poisson_ratio, thickness };
  enum { angle, edge, first_area, second_area };
  using has = Has<Energy>;
  static constexpr const char* id = "shell";
  static constexpr const char* summary = "bending of a thin shell at the edge of two triangles";
  static constexpr const char* reference =
      "E. Grinspun, A. N. Hirani, M. Desbrun, P. Schroeder, Discrete shells, Symp. Computer Animation 2003, 62-67";
  static constexpr Shape shape = Shape::hinge;
  static constexpr Scalar invariants[] = {dihedral_of(0, 1, 2, 3), at_rest(length_of(0, 1)), at_rest(area_of(0, 1, 2)),
                                          at_rest(area_of(0, 1, 3))};
  static constexpr Parameter parameters[] = {
      number("youngs_modulus", "Pa", "Young's modulus").at_least(0).learnable(),
      number("poisson_ratio", "1", "Poisson's ratio").above(-1).below(0.5).learnable(0.1),
      number("thickness", "m", "at rest").above(0).learnable()};

  // D l^2 / (A1 + A2)
  template <class Real>
  static Real stiffness(const SeveralOf<Real, 4>& e, const Parameters<Real>& p) {
    const Real areas = e.reference[first_area] + e.reference[second_area];
    const Real t = p[thickness], nu = p[poisson_ratio];
    const Real rigidity = p[youngs_modulus] * t * t * t / (12.0 * (1.0 - nu * nu));
    return rigidity * e.reference[edge] * e.reference[edge] / areas;
  }
  template <class Real>
  static Real energy(const SeveralOf<Real, 4>& e, const Parameters<Real>& p) {
    const Real x = e.q[angle] - e.reference[angle];
    return 0.5 * stiffness(e, p) * x * x;
  }
  template <class Real>
  static std::array<Real, 4> force(const SeveralOf<Real, 4>& e, const Parameters<Real>& p) {
    return {stiffness(e, p) * (e.q[angle] - e.reference[angle])};
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.shell", "0.1.0", "springnet", "MIT", Shell);
