// A polynomial in the elongation x = l - l0, odd so that it pushes as it pulls:
//   T = k x + k3 x^3 + k5 x^5,  E = k x^2 / 2 + k3 x^4 / 4 + k5 x^6 / 6.
// A negative coefficient softens the spring; where T falls, a network may have several equilibria.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Nonlinear : SpringFunction {
  enum { stiffness, cubic, quintic };
  using has = Has<Energy>;
  static constexpr const char* id = "nonlinear";
  static constexpr const char* summary = "odd polynomial, T = stiffness x + cubic x^3 + quintic x^5, x = l - l0";
  static constexpr const char* reference =
      "G. Duffing, Erzwungene Schwingungen bei veraenderlicher Eigenfrequenz, 1918";
  static constexpr bool fits_elements = true;
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "slope of the tension at the rest length").learnable(),
      number("cubic", "N/m^3", "coefficient of the third power").preset(0).learnable(),
      number("quintic", "N/m^5", "coefficient of the fifth power").preset(0).learnable()};

  static auto force(const auto& e, const auto& p) {
    const auto x = e.elongation();
    return x * polynomial(x * x, p[stiffness], p[cubic], p[quintic]);
  }

  static auto energy(const auto& e, const auto& p) {
    const auto x = e.elongation();
    const auto x2 = x * x;
    return x2 * polynomial(x2, p[stiffness] / 2.0, p[cubic] / 4.0, p[quintic] / 6.0);
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.nonlinear", "0.1.0", "springnet", "MIT", Nonlinear);
