// A dashpot along the spring: Q = d u, with the rate of its length u. It conserves angular momentum.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct LinearViscosity : ViscosityFunction {
  static constexpr const char* id = "linear";
  static constexpr const char* summary = "dashpot along the spring, Q = damping dl/dt";
  static constexpr bool fits_elements = true;
  static constexpr bool monotone = true;
  static constexpr Parameter parameters[] = {
      number("damping", "N s/m", "force per rate of the length").at_least(0).learnable()};

  static auto force(const auto& e, const auto& p) { return p[0] * e.rate; }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.viscosity.linear", "0.1.0", "springnet", "MIT", LinearViscosity);
