// Damping of the whole relative velocity of both ends, including the part across the spring: Q = d |v1 - v2| along v1 -
// v2. It does not conserve angular momentum: rigid rotation is damped, too.
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct RelativeViscosity : ViscosityFunction {
  static constexpr const char* id = "relative";
  static constexpr const char* summary = "damps the relative velocity of both ends, Q = damping |v1 - v2|";
  static constexpr const char* reference =
      "A. Nuernberger, A. Radetzky, R. Kruse, A Problem Specific Recurrent Neural Network for the Description and "
      "Simulation of Dynamic Spring Models, IJCNN 1998";
  static constexpr std::uint32_t invariant = SPRINGNET_RELATIVE_SPEED;
  static constexpr Parameter parameters[] = {
      number("damping", "N s/m", "force per relative speed").at_least(0).learnable()};

  static auto force(const auto& e, const auto& p) { return p[0] * e.q; }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.viscosity.relative", "0.1.0", "springnet", "MIT", RelativeViscosity);
