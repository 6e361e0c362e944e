// A mass point in a viscous medium at rest: a = (F - b v) / m.
#include <springnet/sdk/neuron.hpp>

namespace {
using namespace springnet::sdk;

struct Dragged : Neuron {
  static constexpr const char* id = "dragged";
  static constexpr const char* summary = "mass point in a viscous medium at rest, a = (F - drag v) / m";
  static constexpr Parameter parameters[] = {
      number("drag", "kg/s", "force of the medium per speed").at_least(0).learnable()};

  static auto acceleration(const auto& n, const auto& p) { return (n.force - p[0] * n.velocity) / n.mass; }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.neuron.dragged", "0.1.0", "springnet", "MIT", Dragged);
