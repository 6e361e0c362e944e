// A compressible neo-Hookean tetrahedron: neo_hookean.hpp has the formulas.
#include <springnet/sdk/law.hpp>

#include "neo_hookean.hpp"

namespace {
using namespace springnet::sdk;
namespace neo_hookean = springnet::plugins::neo_hookean;

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
    return e.reference[6] * neo_hookean::energy(e, p[youngs_modulus], p[poisson_ratio]);
  }

  template <class Real>
  static std::array<Real, 7> force(const SeveralOf<Real, 7>& e, const Parameters<Real>& p) {
    const Real mu = neo_hookean::shear_modulus(p[youngs_modulus], p[poisson_ratio]);
    std::array<Real, 7> result{};
    add_edge_forces(neo_hookean::by_edges(e, mu), e.q, result.data());
    result[6] = neo_hookean::by_volume(e, mu, p[poisson_ratio]);
    return result;
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.solid", "0.1.0", "springnet", "MIT", Solid);
