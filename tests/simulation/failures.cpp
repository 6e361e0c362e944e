// Laws that answer nonsense, and laws the engine cannot evaluate: errors that name law and spring. The laws are plugins
// registered statically.

#include <doctest/doctest.h>

#include <limits>

#include <springnet/error.hpp>

#define SPRINGNET_STATIC_PLUGIN failures
#include <springnet/sdk/law.hpp>

#include "nets.hpp"

namespace {

namespace sdk = springnet::sdk;

// Nonsense beyond a length, as a square root of something negative would be.
struct NanBeyond : sdk::SpringFunction {
  static constexpr const char* id = "nan_beyond";
  static constexpr const char* summary = "not a number beyond a length";
  static constexpr sdk::Parameter parameters[] = {sdk::number("length", "m", "where it fails").at_least(0)};
  static auto force(const auto& e, const auto& p) { return sqrt(p[0] - e.q) * 0.0; }
};

struct Throws : sdk::SpringFunction {
  static constexpr const char* id = "throws";
  static constexpr const char* summary = "fails with a message";
  static auto force(const auto& e, const auto&) {
    if (e.q > 1.5) throw std::runtime_error("the tissue is torn");
    return e.q * 0.0;
  }
};

struct Remembers : sdk::SpringFunction {
  static constexpr const char* id = "remembers";
  static constexpr const char* summary = "has internal state";
  static constexpr sdk::Parameter states[] = {sdk::number("damage", "1", "0 is whole")};
  static auto force(const auto& e, const auto&) { return e.q * e.state(0); }
  template <class Real>
  static std::array<Real, 1> state_rates(const sdk::Element<Real>& e, const sdk::Parameters<Real>&) {
    return {e.q};
  }
};

}  // namespace

SPRINGNET_PLUGIN("test.failures", "1.0.0", "springnet", "MIT", NanBeyond, Throws, Remembers);

using namespace springnet;
using namespace springnet::testing;

namespace {

std::shared_ptr<const PluginHost> host() {
  auto plugin_host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  REQUIRE(plugin_host->add(springnet_plugin_entry_failures));
  return plugin_host;
}

}  // namespace

TEST_CASE("a law that answers not a number is named, with its spring and nodes, and the last good state stays") {
  for (const LawUse& integrator :
       {recurrent(synchronous, 1e-9), recurrent(wavefront, 1e-9), single_sweep(), cvode(1e-6)}) {
    CAPTURE(integrator.id);
    Network net;
    const MaterialIndex fine = net.add_material(damped(0.0, 0.0));
    const MaterialIndex bad = net.add_material({LawUse{"nan_beyond", {{"length", 1.5}}}, std::nullopt});
    for (int k = 0; k < 5; ++k) net.add_node(point({double(k), 0, 0}, 1.0, {k >= 3 ? 1.0 : 0.0, 0, 0}));
    for (SpringIndex s = 0; s < 4; ++s) net.add_spring(s, s + 1, s == 2 ? bad : fine);
    SimulationOptions options;
    options.time_step = 0.1;
    options.integrator = integrator;
    Simulation simulation(net, host(), options);
    std::string text;
    try {
      simulation.advance_to(2.0);
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::simulation);
      text = error.what();
    }
    CAPTURE(text);
    CHECK(text.find("nan_beyond") != std::string::npos);
    CHECK(text.find("spring 2 (nodes 2 and 3") != std::string::npos);
    CHECK(simulation.time() >= 0.3);
    CHECK(simulation.time() < 0.75);
    CHECK(simulation.positions().allFinite());
    CHECK(simulation.velocities().allFinite());
  }
}

TEST_CASE("what a law throws arrives as the error of the step") {
  for (const LawUse& integrator : {recurrent(synchronous, 1e-9), recurrent(wavefront, 1e-9), cvode(1e-6)}) {
    Network net;
    net.add_node(point({0, 0, 0}));
    net.add_node(point({1, 0, 0}, 1.0, {1, 0, 0}));
    net.add_spring(0, 1, net.add_material({LawUse{"throws", {}}, std::nullopt}));
    SimulationOptions options;
    options.time_step = 0.1;
    options.integrator = integrator;
    Simulation simulation(net, host(), options);
    CHECK_THROWS_WITH_AS(simulation.advance_to(2.0), doctest::Contains("the tissue is torn"), Error);
  }
}

TEST_CASE("a law with internal state is refused by name") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}));
  net.add_spring(0, 1, net.add_material({LawUse{"remembers", {}}, std::nullopt}));
  CHECK_THROWS_WITH_AS(Simulation(net, host(), {}), doctest::Contains("'remembers': has internal state"), Error);
}

TEST_CASE("laws, neurons and integrators that are not there, parameters out of range") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}));
  net.add_spring(0, 1, net.add_material({LawUse{"liner", {}}, std::nullopt}));
  CHECK_THROWS_WITH_AS(Simulation(net, host(), {}), doctest::Contains("'linear'"), Error);

  Network negative;
  negative.add_node(point({0, 0, 0}));
  negative.add_node(point({1, 0, 0}));
  negative.add_spring(0, 1, negative.add_material(damped(-1.0, 0.0)));
  CHECK_THROWS_WITH_AS(Simulation(negative, host(), {}), doctest::Contains("stiffness"), Error);

  Network fine;
  fine.add_node(point({0, 0, 0}));
  SimulationOptions options;
  options.integrator = {"recurent", {}};
  CHECK_THROWS_WITH_AS(Simulation(fine, host(), options), doctest::Contains("recurrent"), Error);
  options.integrator = {"recurrent", {{"sweps", 1}}};
  CHECK_THROWS_WITH_AS(Simulation(fine, host(), options), doctest::Contains("sweeps"), Error);
}
