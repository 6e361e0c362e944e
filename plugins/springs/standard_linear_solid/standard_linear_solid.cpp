// A spring beside a spring and a dashpot in series (Maxwell's form of the standard linear solid, or Zener's model).
// With the elongation x = l - l0 and that of the dashpot z:
//   T = k x + k1 (x - z),   z' = (x - z) / tau,   E = k x^2 / 2 + k1 (x - z)^2 / 2.
// Its stiffness falls from k + k1 for fast elongations to k for slow ones: held at a constant length the tension
// relaxes in the time tau; under a constant tension it creeps in the time tau (k + k1) / k.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct StandardLinearSolid : SpringFunction {
  enum { stiffness, fast_stiffness, relaxation_time, starts_relaxed };
  enum { flow };
  using has = Has<Energy, Start>;
  static constexpr const char* id = "standard_linear_solid";
  static constexpr const char* summary =
      "a spring beside a spring and dashpot in series: relaxes and creeps to a finite stiffness";
  static constexpr const char* reference = "C. Zener, Elasticity and Anelasticity of Metals, 1948";
  static constexpr bool fits_elements = true;
  static constexpr bool smooth_rates = true;
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "slope of the tension over a slow elongation").at_least(0).learnable(),
      number("fast_stiffness", "N/m", "what a fast elongation adds to it").at_least(0).learnable(),
      number("relaxation_time", "s", "in which what it adds falls to 1/e at constant length").above(0).learnable(),
      boolean("starts_relaxed", "the dashpot begins with the elongation at the start")};
  static constexpr Parameter states[] = {number("flow", "m", "elongation of the dashpot").preset(0).learnable(0.01)};

  static auto force(const auto& e, const auto& p) {
    return p[stiffness] * e.elongation() + p[fast_stiffness] * (e.elongation() - e.state(flow));
  }

  static auto energy(const auto& e, const auto& p) {
    const auto x = e.elongation(), fast = x - e.state(flow);
    return 0.5 * (p[stiffness] * x * x + p[fast_stiffness] * fast * fast);
  }

  static auto state_rates(const auto& e, const auto& p) {
    return std::array{(e.elongation() - e.state(flow)) * (1.0 / p[relaxation_time])};
  }

  static auto start(const auto& e, const auto& p) {
    return std::array{p[starts_relaxed] != 0.0 ? e.elongation() : e.state(flow)};
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.standard_linear_solid", "0.1.0", "springnet", "MIT", StandardLinearSolid);
