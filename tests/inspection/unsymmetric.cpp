// Largest time steps where the linearised network is not symmetric: eigenvalues in complex pairs, and a limit for
// blocks as well. Against a closed form and against runs just below and just above.
#include <memory>
#include <random>
#include <string>
#include <tuple>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/inspection.hpp>
#include <springnet/sdk/neuron.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"

namespace charge {
using namespace springnet::sdk;

// A charge in a magnetic field along z.
struct Charge : Neuron {
  static constexpr const char* id = "charge";
  static constexpr const char* summary = "mass point in a magnetic field, a = F / m + frequency v x e_z";
  static constexpr Parameter parameters[] = {number("frequency", "1/s", "of its circles, times 2 pi")};

  template <class Real>
  static Vector<Real> acceleration(const springnet::sdk::Node<Real>& n, const Parameters<Real>& p) {
    const Vector<Real> turn{n.velocity.y, -n.velocity.x, Real(0.0)};
    return n.force / n.mass + p[0] * turn;
  }
};

}  // namespace charge

SPRINGNET_PLUGIN("springnet.test.charge", "1.0.0", "springnet", "MIT", charge::Charge);

using namespace springnet;
using Kind = TimeConstantLimit::Kind;

namespace {

std::shared_ptr<const PluginHost> plugins_with_charge() {
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  REQUIRE(host->add(springnet_plugin_entry));
  return host;
}

bool settles(const Network& net, const std::shared_ptr<const PluginHost>& plugins, double update, double time_step) {
  SimulationOptions options;
  options.time_step = time_step;
  options.threads = 1;
  // Forces are about 1e-4 N, rounding leaves 1e-13 N.
  options.integrator = testing::recurrent(update, 1e-10, {{"max_sweeps", 4000.0}});
  Simulation simulation(net, plugins, options);
  try {
    simulation.step();
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

TEST_CASE("a single charge: eigenvalues +- i t frequency; blocks solve it in one sweep") {
  Network net;
  Node node;
  node.neuron = net.add_neuron({"charge", {{"frequency", 5.0}}});
  net.add_node(node);
  const Inspection found = inspect(net, *plugins_with_charge());
  for (const char* const rule : {"synchronous", "wavefront"}) {
    CHECK(found.limit(rule).time_constant == doctest::Approx(0.2).epsilon(2e-3));  // the search's accuracy, twice
  }
  CHECK(found.limit("block").kind == Kind::none);
}

TEST_CASE("charges on springs settle just below their limits, and not just above") {
  const auto plugins = plugins_with_charge();
  for (const double frequency : {2.0, 20.0}) {
    Network net = testing::chain(12, Vector3::Zero(), {1.0, 0.2, 0.1}, testing::damped(30.0, 0.5), 0.5);
    const std::uint32_t charge = net.add_neuron({"charge", {{"frequency", frequency}}});
    std::mt19937 random(5);
    const auto speed = [&] { return 1e-4 * (static_cast<double>(random()) * 0x1p-32 - 0.5); };
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
      Node node = net.nodes()[k];
      const double x = speed(), y = speed(), z = speed();
      node.velocity = {x, y, z};
      node.neuron = charge;
      net.set_node(k, node);
    }
    const Inspection found = inspect(net, *plugins);
    // Waves start elsewhere in every sweep; the limit is that of the first order.
    for (const auto& [rule, update, margin] :
         {std::tuple{"synchronous", testing::synchronous, 0.03}, std::tuple{"wavefront", testing::wavefront, 0.08}}) {
      const std::string name(rule);
      CAPTURE(name);
      CAPTURE(frequency);
      const TimeConstantLimit& limit = found.limit(rule);
      CAPTURE(limit.time_constant);
      REQUIRE(limit.kind == Kind::known);
      CHECK(settles(net, plugins, update, (1.0 - margin) * limit.time_constant));
      CHECK_FALSE(settles(net, plugins, update, (1.0 + margin) * limit.time_constant));
    }
    // Turning forces do no work, and springs that only pull hold: there is no limit to find.
    for (const auto& [rule, update] : {std::pair{"block", testing::block}, std::pair{"coloured", testing::coloured}}) {
      CHECK(found.limit(rule).kind == Kind::none);
      CHECK(settles(net, plugins, update, 10.0 * found.limit("synchronous").time_constant));
    }
  }
}
