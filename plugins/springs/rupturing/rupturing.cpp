// Hooke's law up to a threshold: T = k (l - l0) while T < strength, then the spring is removed. It breaks in tension,
// in compression only if breaks_in_compression is set.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Rupturing : SpringFunction {
  enum { stiffness, strength, breaks_in_compression };
  using has = Has<Energy, Margin>;
  static constexpr const char* id = "rupturing";
  static constexpr const char* summary = "Hooke's law, T = stiffness (l - l0), until T reaches the strength";
  static constexpr bool fits_elements = true;
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "tension per elongation").at_least(0).learnable(),
      number("strength", "N", "tension at which the spring breaks").above(0).learnable(),
      boolean("breaks_in_compression", "it also breaks where it pushes with its strength")};

  static auto force(const auto& e, const auto& p) { return p[stiffness] * e.elongation(); }

  static auto energy(const auto& e, const auto& p) { return 0.5 * p[stiffness] * e.elongation() * e.elongation(); }

  static auto margin(const auto& e, const auto& p) {
    const auto tension = p[stiffness] * e.elongation();
    // By the reciprocal, which is the same for all springs of a material.
    return 1.0 - (p[breaks_in_compression] != 0.0 ? abs(tension) : tension) * (1.0 / p[strength]);
  }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.spring.rupturing", "0.1.0", "springnet", "MIT", Rupturing);
