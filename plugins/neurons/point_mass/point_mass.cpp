// A mass point: a = F / m.
#include <springnet/sdk/neuron.hpp>

namespace {
using namespace springnet::sdk;

struct PointMass : Neuron {
  static constexpr const char* id = "point_mass";
  static constexpr const char* summary = "mass point, a = F / m";

  static auto acceleration(const auto& n, const auto&) { return n.force / n.mass; }
};

}  // namespace

SPRINGNET_PLUGIN("springnet.neuron.point_mass", "0.1.0", "springnet", "MIT", PointMass);
