// The stiffening of soft tissue. Fung found that the slope of tension over stretch grows linearly with the tension,
// dT/de = a (T + b), with the strain e = (l - l0) / l0. Integrated from T = 0 at rest, and written with the stiffness
// at rest k = a b / l0:
//   T = (k l0 / a) (exp(a e) - 1),   E = k (l0 / a)^2 (exp(a e) - 1 - a e).
// The same formula holds in compression: the spring softens and pushes with less than k l0 / a, as strands of tissue
// do. It does not resist collapse; if a net needs that, other springs or an enclosed volume must provide it. The rest
// length must be above 0.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

// exp(x) - 1 - x. Near 0, where the terms cancel, by the series x^2/2! + x^3/3! + …; for |x| < 1/2 its remainder after
// x^15 is below 1e-16 of the sum. Both are computed, so that loops have no branch.
template <class Real>
Real expm1_minus_x(const Real& x) {
  Real sum(1.0);
  for (int n = 15; n > 2; --n) sum = 1.0 + sum * (x * (1.0 / n));
  return abs(x) < 0.5 ? 0.5 * x * x * sum : expm1(x) - x;
}

struct Exponential : SpringFunction {
  enum { stiffness, exponent };
  using has = Has<Energy>;
  static constexpr const char* id = "exponential";
  static constexpr const char* summary = "soft tissue, T = stiffness l0 / exponent (exp(exponent (l - l0) / l0) - 1)";
  static constexpr const char* reference =
      "Y. C. Fung, Elasticity of soft tissues in simple elongation, Am. J. Physiol. 213 (1967) 1532-1544";
  static constexpr bool fits_elements = true;
  static constexpr bool divides_by_reference = true;
  static constexpr bool monotone = true;
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "slope of the tension at the rest length").at_least(0).learnable(),
      number("exponent", "1", "how fast the stiffness grows with the strain").above(0).preset(10).learnable(10)};

  static auto force(const auto& e, const auto& p) {
    return p[stiffness] * e.reference / p[exponent] * expm1(p[exponent] * e.strain());
  }

  static auto energy(const auto& e, const auto& p) {
    const auto length = e.reference / p[exponent];
    return p[stiffness] * length * length * expm1_minus_x(p[exponent] * e.strain());
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.exponential", "0.1.0", "springnet", "MIT", Exponential);
