// A damper whose force grows with a power of the rate u of its length: Q = d |u|^n sign(u). n = 1 is the dashpot, 2 the
// drag of a turbulent flow, below 1 a shear-thinning fluid.
// For n < 1 the slope of that formula at u = 0 is infinite, and no implicit method can step across it. The force is
// then linear for |u| < linear_below and continuous there: Q = d linear_below^(n - 1) u.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct PowerViscosity : ViscosityFunction {
  enum { damping, exponent, linear_below };
  static constexpr const char* id = "power";
  static constexpr const char* summary = "damper with a power of the rate, Q = damping |dl/dt|^exponent sign(dl/dt)";
  static constexpr const char* reference =
      "C. J. Black, N. Makris, Viscous heating of fluid dampers under small and large amplitude motions, J. Eng. Mech. "
      "133 (2007) 566-577";
  static constexpr bool fits_elements = true;
  static constexpr bool monotone = true;
  static constexpr Parameter parameters[] = {
      number("damping", "N (s/m)^exponent", "force at a rate of 1 m/s").at_least(0).learnable(),
      number("exponent", "1", "power of the rate").above(0).at_most(10).preset(2).learnable(),
      number("linear_below", "m/s", "exponents below 1: rate under which the force is linear").above(0).preset(1e-6)};

  static auto force(const auto& e, const auto& p) {
    // 1e-307: 0^(exponent - 1) may have no derivative; this one is finite and is multiplied by u = 0.
    const auto least = p[exponent] < 1.0 ? p[linear_below] : 1e-307;
    return p[damping] * e.rate * quick_pow(max(abs(e.rate), least), p[exponent] - 1.0);
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.viscosity.power", "0.1.0", "springnet", "MIT", PowerViscosity);
