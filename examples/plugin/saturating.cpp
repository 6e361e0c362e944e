#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

// T = T_max tanh(k e / T_max): Hooke's law for small elongations e, never more than T_max for great ones.
struct Saturating : SpringFunction {
  static constexpr const char* id = "saturating";
  static constexpr const char* summary = "linear at first, never above a greatest tension";
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "tension per small elongation").above(0).learnable(100),
      number("greatest_tension", "N", "tension that great elongations approach").above(0)};

  template <class Real>
  static Real force(const Element<Real>& e, const Parameters<Real>& p) {
    return p[1] * tanh(p[0] * e.elongation() / p[1]);
  }
};
}  // namespace
SPRINGNET_PLUGIN("org.example.saturating", "1.0.0", "springnet", "MIT", Saturating);
