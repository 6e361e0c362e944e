// Viscoplastic flow after Perzyna, with linear kinematic hardening. Of the elongation x = l - l0 the part z is plastic:
//   T = k (x - z),   s = T - H z,   z' = sign(s) max(|s| - Y, 0) / (k tau),   E = k (x - z)^2 / 2 + H z^2 / 2.
// The back tension H z moves the elastic range along, so that a spring which has yielded in tension yields earlier in
// compression. As tau goes to 0, |s| stays at most Y: rate-independent plasticity. It dissipates s z' >= 0.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Plastic : SpringFunction {
  enum { stiffness, yield_tension, hardening, relaxation_time };
  enum { flow };
  using has = Has<Energy>;
  static constexpr const char* id = "plastic";
  static constexpr const char* summary = "Hooke's law that yields: viscoplastic flow with kinematic hardening";
  static constexpr const char* reference =
      "P. Perzyna, Fundamental problems in viscoplasticity, Adv. Appl. Mech. 9 (1966) 243-377";
  static constexpr bool fits_elements = true;
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "tension per elastic elongation").above(0).learnable(),
      number("yield_tension", "N", "tension from which on it flows").above(0).learnable(),
      number("hardening", "N/m", "back tension per plastic elongation").at_least(0).preset(0).learnable(),
      number("relaxation_time", "s", "in which tension above the yield tension falls to 1/e, without hardening")
          .above(0)
          .learnable()};
  static constexpr Parameter states[] = {number("flow", "m", "plastic elongation").preset(0).learnable(0.01)};

  static auto force(const auto& e, const auto& p) { return p[stiffness] * (e.elongation() - e.state(flow)); }

  static auto energy(const auto& e, const auto& p) {
    const auto elastic = e.elongation() - e.state(flow);
    return 0.5 * (p[stiffness] * elastic * elastic + p[hardening] * e.state(flow) * e.state(flow));
  }

  static auto state_rates(const auto& e, const auto& p) {
    const auto drive = force(e, p) - p[hardening] * e.state(flow);
    const auto over = max(drive - p[yield_tension], 0.0) + min(drive + p[yield_tension], 0.0);
    return std::array{over * (1.0 / (p[stiffness] * p[relaxation_time]))};
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.plastic", "0.1.0", "springnet", "MIT", Plastic);
