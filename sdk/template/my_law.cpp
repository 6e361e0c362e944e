// A spring that pulls but does not push: T = k max(l - l0, 0).
#include <springnet/sdk/law.hpp>

namespace {
using namespace springnet::sdk;

struct MyLaw : SpringFunction {
  using has = Has<Energy>;
  static constexpr const char *id = "my_law", *summary = "pulls like Hooke's law, does not push";
  static constexpr bool acts_in_compression = false;
  static constexpr Parameter parameters[] = {number("stiffness", "N/m", "tension per elongation").at_least(0)};

  static auto force(const auto& e, const auto& p) { return p[0] * max(e.elongation(), 0.0); }

  static auto energy(const auto& e, const auto& p) { return 0.5 * force(e, p) * e.elongation(); }
};
}  // namespace

SPRINGNET_PLUGIN("org.example.my_law", "1.0.0", "your name", "MIT", MyLaw);
