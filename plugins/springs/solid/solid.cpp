// A compressible neo-Hookean tetrahedron. Per volume at rest, with I1 = tr C and J = V / V0 (signed),
//   W = mu/2 (I1 - 3) - mu (J - 1) + kappa/2 (J - 1)^2,   mu = E / (2 (1 + nu)),  kappa = mu / (1 - 2 nu).
// Near rest it is Hooke's law with E and nu. kappa > 0 for every nu in (-1, 1/2), and W is finite for every J, so that
// a tetrahedron that was turned inside out is pushed back.
#include <springnet/sdk/law.hpp>
#include <springnet/sdk/law/simplex.hpp>

namespace {
using namespace springnet::sdk;

struct Solid : SpringFunction {
  enum { youngs_modulus, poisson_ratio };
  using has = Has<Energy>;
  static constexpr const char* id = "solid";
  static constexpr const char* summary = "tetrahedron of a compressible neo-Hookean material";
  static constexpr const char* reference =
      "B. Smith, F. de Goes, T. Kim, Stable neo-Hookean flesh simulation, ACM Trans. Graph. 37 (2018) 12, without its "
      "logarithm";
  static constexpr Shape shape = Shape::tetrahedron;
  static constexpr Scalar invariants[] = {SPRINGNET_TETRAHEDRON_EDGES, volume_of(0, 1, 2, 3)};
  static constexpr Parameter parameters[] = {
      number("youngs_modulus", "Pa", "Young's modulus at rest").at_least(0).learnable(),
      number("poisson_ratio", "1", "Poisson's ratio at rest").above(-1).below(0.5).learnable(0.1)};

  static auto energy(const auto& e, const auto& p) {
    const auto mu = p[youngs_modulus] / (2.0 * (1.0 + p[poisson_ratio]));
    const auto rest = gram<3>(e.reference, e.reference);
    const auto trace = contracted(rest.adjugate(), gram<3>(e.q, e.q)) / rest.determinant();
    const auto j = e.q[6] / e.reference[6] - 1.0;
    return e.reference[6] * mu * (0.5 * (trace - 3.0) + j * (0.5 * j / (1.0 - 2.0 * p[poisson_ratio]) - 1.0));
  }

  template <class Real>
  static std::array<Real, 7> force(const SeveralOf<Real, 7>& e, const Parameters<Real>& p) {
    const Real mu = p[youngs_modulus] / (2.0 * (1.0 + p[poisson_ratio]));
    const Symmetric<Real, 3> rest = gram<3>(e.reference, e.reference);
    // V0 dW/dG = V0 mu/2 R^-1, where det R = (6 V0)^2
    const Symmetric<Real, 3> stress = mu / (72.0 * e.reference[6]) * rest.adjugate();
    std::array<Real, 7> result{};
    add_edge_forces(stress, e.q, result.data());
    const Real j = e.q[6] / e.reference[6] - 1.0;
    result[6] = mu * (j / (1.0 - 2.0 * p[poisson_ratio]) - 1.0);
    return result;
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.solid", "0.1.0", "springnet", "MIT", Solid);
