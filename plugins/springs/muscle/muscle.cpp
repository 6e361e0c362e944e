// A muscle after Hill: contractile fibres with activation a from 0 to 1 beside passive tissue. With the length L = l /
// l0 in units of the rest length, at which the fibres are strongest, and the speed V = l' / (l0 v_max):
//   T = F (a f_l(L) f_v(V) + f_p(L) + d V).
// Force and length after Thelen (2003): the fibres f_l = exp(-(L - 1)^2 / w), the tissue
// f_p = (exp(k (L - 1) / e) - 1) / (exp(k) - 1) above L = 1, which is 1 at the strain e.
// Force and speed: in shortening Hill's hyperbola (f_v + c)(c - V) = c (1 + c), that is f_v = (1 + V) / (1 - V / c),
// which is 0 at V = -1 and stays 0 beyond; in lengthening a hyperbola with the same slope at V = 0 that tends to f_max.
// (Thelen's has twice that slope in lengthening; a kink at rest would cost implicit methods dear.)
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Muscle : SpringFunction {
  enum { strength, maximum_speed, curvature, lengthening_force, width, passive_stiffness, passive_strain, damping };
  enum { activation };
  static constexpr const char* id = "muscle";
  static constexpr const char* summary =
      "Hill's muscle: contracts with the input 'activation', at most with `strength`";
  static constexpr const char* reference =
      "A. V. Hill, The heat of shortening and the dynamic constants of muscle, Proc. R. Soc. B 126 (1938) 136-195; "
      "D. G. Thelen, Adjustment of muscle mechanics model parameters to simulate dynamic contractions in older adults, "
      "J. Biomech. Eng. 125 (2003) 70-77";
  static constexpr bool reads_rate = true;
  static constexpr bool adds_power = true;
  static constexpr bool not_zero_at_rest = true;
  static constexpr bool divides_by_reference = true;
  static constexpr Parameter parameters[] = {
      number("strength", "N", "F: tension of the fully activated muscle at its rest length").at_least(0).learnable(100),
      number("maximum_speed", "1/s", "v_max: shortening without load, in rest lengths per second")
          .above(0)
          .preset(10)
          .learnable(10),
      number("curvature", "1", "c: of Hill's hyperbola, smaller: more curved").above(0).preset(0.25).learnable(0.25),
      number("lengthening_force", "1", "f_max: force in fast lengthening, in units of the strength")
          .above(1)
          .preset(1.4)
          .learnable(),
      number("width", "1", "w: of the fibres' force over length").above(0).preset(0.45).learnable(0.5),
      number("passive_stiffness", "1", "k: how fast the passive force grows")
          .at_least(0.001)
          .at_most(100)
          .preset(5)
          .learnable(5),
      number("passive_strain", "1", "e: strain at which the passive force is the strength")
          .above(0)
          .preset(0.6)
          .learnable(0.5),
      number("damping", "1", "d: viscous force at v_max, in units of the strength")
          .at_least(0)
          .preset(0.1)
          .learnable(0.1)};
  static constexpr Parameter inputs[] = {
      number("activation", "1", "share of the fibres that pull").at_least(0).at_most(1).preset(0)};

  // Of the fibres, over the speed in units of v_max.
  static auto force_of_speed(const auto& v, const auto& p) {
    // Where v is 0 only one of the two has the derivative of v.
    const auto shorter = min(v, 0.0), longer = v - shorter;
    const auto shortening = max(1.0 + shorter, 0.0) / (1.0 - shorter * (1.0 / p[curvature]));
    const auto more = p[lengthening_force] - 1.0;
    const auto x = longer * ((1.0 + 1.0 / p[curvature]) / more);
    return shortening + more * x / (1.0 + x);
  }

  static auto force(const auto& e, const auto& p) {
    const auto stretch = e.strain();
    const auto v = e.rate * (1.0 / (e.reference * p[maximum_speed]));
    const auto fibres = exp(stretch * stretch * (-1.0 / p[width])) * force_of_speed(v, p);
    const auto tissue =
        expm1(max(stretch, 0.0) * (p[passive_stiffness] / p[passive_strain])) * (1.0 / expm1(p[passive_stiffness]));
    return p[strength] * (e.input(activation) * fibres + tissue + p[damping] * v);
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.muscle", "0.1.0", "springnet", "MIT", Muscle);
