// Hooke's law: T = k (l - l0), E = k (l - l0)^2 / 2.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct Linear : SpringFunction {
  using has = Has<Energy>;
  static constexpr const char *id = "linear", *summary = "Hooke's law, T = stiffness (l - l0)";
  static constexpr bool fits_elements = true;
  static constexpr bool monotone = true;
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "tension per elongation").at_least(0).learnable()};

  static auto force(const auto& e, const auto& p) { return p[0] * e.elongation(); }
  static auto energy(const auto& e, const auto& p) { return 0.5 * p[0] * e.elongation() * e.elongation(); }
};
}  // namespace

SPRINGNET_PLUGIN("springnet.spring.linear", "0.1.0", "springnet", "MIT", Linear);
