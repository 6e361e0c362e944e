// A spring and a dashpot in series. The dashpot is longer by z than at the start, the spring takes the rest of the
// elongation x = l - l0:
//   T = k (x - z),   z' = (x - z) / tau,   E = k (x - z)^2 / 2.
// Held at a constant length its tension falls as exp(-t / tau); the dashpot's damping is k tau.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Maxwell : SpringFunction {
  enum { stiffness, relaxation_time, starts_relaxed };
  enum { flow };
  using has = Has<Energy, Start>;
  static constexpr const char* id = "maxwell";
  static constexpr const char* summary = "spring and dashpot in series: its tension relaxes at constant length";
  static constexpr const char* reference =
      "J. C. Maxwell, On the dynamical theory of gases, Phil. Trans. 157 (1867) 49";
  static constexpr bool fits_elements = true;
  static constexpr bool smooth_rates = true;
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "of the spring: slope of the tension over a fast elongation").at_least(0).learnable(),
      number("relaxation_time", "s", "in which the tension falls to 1/e at constant length").above(0).learnable(),
      boolean("starts_relaxed", "the dashpot begins with the elongation at the start, so that there is no tension")};
  static constexpr Parameter states[] = {number("flow", "m", "elongation of the dashpot").preset(0).learnable(0.01)};

  static auto force(const auto& e, const auto& p) { return p[stiffness] * (e.elongation() - e.state(flow)); }

  static auto energy(const auto& e, const auto& p) {
    const auto x = e.elongation() - e.state(flow);
    return 0.5 * p[stiffness] * x * x;
  }

  static auto state_rates(const auto& e, const auto& p) {
    return std::array{(e.elongation() - e.state(flow)) * (1.0 / p[relaxation_time])};
  }

  static auto start(const auto& e, const auto& p) {
    return std::array{p[starts_relaxed] != 0.0 ? e.elongation() : e.state(flow)};
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.maxwell", "0.1.0", "springnet", "MIT", Maxwell);
