// A spring that softens before it breaks. With the strain e = (l - l0) / l0 and the damage d, from 0 to 1:
//   T = (1 - d) k (l - l0),   d' = max(g(e) - d, 0) / tau,   E = (1 - d) k (l - l0)^2 / 2.
// g is the damage with which the tension falls in a straight line from the threshold strain e0 to 0 at the failure
// strain ef = e0 + es (J. Lemaitre's scalar damage with linear softening):
//   g = ef / es (1 - e0 / e)   for e0 < e < ef,  0 before, 1 after.
// It breaks where d reaches `breaking_damage`. Damage does not heal; compression neither damages nor is weakened less.
// It dissipates k (l - l0)^2 / 2 d' >= 0.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Damaging : SpringFunction {
  enum { stiffness, threshold_strain, softening_strain, relaxation_time, breaking_damage };
  enum { damage };
  using has = Has<Energy, Margin>;
  static constexpr const char* id = "damaging";
  static constexpr const char* summary = "Hooke's law that softens with damage, and breaks";
  static constexpr const char* reference = "J. Lemaitre, A Course on Damage Mechanics, 1992";
  static constexpr bool fits_elements = true;
  static constexpr bool divides_by_reference = true;
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "tension per elongation of the undamaged spring").at_least(0).learnable(),
      number("threshold_strain", "1", "from which on it is damaged").above(0).learnable(0.1),
      number("softening_strain", "1", "from the threshold to where it bears nothing in the end")
          .above(0)
          .learnable(0.1),
      number("relaxation_time", "s", "in which the damage approaches that of its strain").above(0).learnable(),
      number("breaking_damage", "1", "at which it is removed").preset(0.99).above(0).at_most(1)};
  static constexpr Parameter states[] = {
      number("damage", "1", "share of the stiffness that is lost").preset(0).at_least(0).at_most(1).learnable(0.1)};

  static auto force(const auto& e, const auto& p) { return (1.0 - e.state(damage)) * p[stiffness] * e.elongation(); }

  static auto energy(const auto& e, const auto& p) { return 0.5 * force(e, p) * e.elongation(); }

  static auto margin(const auto& e, const auto& p) { return 1.0 - e.state(damage) / p[breaking_damage]; }

  static auto state_rates(const auto& e, const auto& p) {
    const auto share = (p[threshold_strain] + p[softening_strain]) / p[softening_strain];
    // Below the threshold the strain is not divided by.
    const auto strain = max(e.strain(), p[threshold_strain]);
    const auto aim = min(share * (1.0 - p[threshold_strain] / strain), 1.0);
    return std::array{max(aim - e.state(damage), 0.0) * (1.0 / p[relaxation_time])};
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.damaging", "0.1.0", "springnet", "MIT", Damaging);
