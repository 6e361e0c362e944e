// Laws of the program itself against the same laws in plugins: bit for bit, in every integrator and rule.
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/host_laws.hpp>

// The sources of the plugins, for their classes alone.
#undef SPRINGNET_PLUGIN
#define SPRINGNET_PLUGIN(...) static_assert(true)
#include "../../plugins/springs/damaging/damaging.cpp"
#include "../../plugins/springs/exponential/exponential.cpp"

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;
namespace sdk = springnet::sdk;

// A plugin's law with a member, so that an object of the program is what computes.
template <class Law>
struct Own : Law {
  std::vector<double> factor{1.0};
  auto force(const auto& e, const auto& p) const { return factor[0] * Law::force(e, p); }
};

std::shared_ptr<const PluginHost> with_own_laws() {
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  host->add(spring_function(Own<Exponential>{}), "own");
  host->add(spring_function(Own<Damaging>{}), "own");
  host->add(viscosity_function(describe("linear", "dashpot", number("damping", "N s/m", "of the dashpot")),
                               [one = 1.0](const auto& e, const auto& p) { return p[0] * e.rate * one; }),
            "own");
  host->add(neuron(describe("point_mass", "a = F / m"), [](const auto& n, const auto&) { return n.force / n.mass; }),
            "own");
  return host;
}

// `owner`: behind the ids of laws and neurons.
Network swinging(LawUse law, const std::string& owner) {
  law.id += owner;
  Network net;
  const MaterialIndex material = net.add_material({law, LawUse{"linear" + owner, {{"damping", 0.4}}}});
  const std::uint32_t model = net.add_neuron({"point_mass" + owner, {}});
  for (int k = 0; k < 6; ++k) {
    springnet::Node node = point({0.5 * k, 0.1 * (k % 2), 0}, 0.1, {0.3 * k, 0, 0.2});
    node.fixed = k == 0;
    node.neuron = model;
    net.add_node(node);
    if (k > 0) net.add_spring(static_cast<NodeIndex>(k - 1), static_cast<NodeIndex>(k), material, 0.5);
  }
  net.set_gravity({0, 0, -9.81});
  return net;
}

Simulation run(const Network& net, const std::shared_ptr<const PluginHost>& host, const LawUse& integrator) {
  SimulationOptions options;
  options.time_step = 5e-3;
  options.integrator = integrator;
  options.threads = 2;
  Simulation simulation(net, host, options);
  simulation.advance_to(0.3);
  return simulation;
}

}  // namespace

TEST_CASE("laws of the host have the bits of the same laws in plugins, in every integrator") {
  const auto host = with_own_laws();
  const std::vector<LawUse> laws{{"exponential", {{"stiffness", 60.0}, {"exponent", 3.0}}},
                                 {"damaging",
                                  {{"stiffness", 60.0},
                                   {"threshold_strain", 0.05},
                                   {"softening_strain", 0.3},
                                   {"relaxation_time", 0.05},
                                   {"breaking_damage", 0.5}}}};
  std::size_t broken = 0;
  for (const LawUse& law : laws) {
    CAPTURE(law.id);
    for (const StateMethod& method : state_methods(1e-9)) {
      CAPTURE(method.name);
      const Simulation own = run(swinging(law, "@own"), host, method.integrator);
      const Simulation shipped = run(swinging(law, ""), plugins(), method.integrator);
      REQUIRE(own.live_spring_count() == shipped.live_spring_count());
      broken += own.spring_count() - own.live_spring_count();
      for (NodeIndex node = 0; node < own.node_count(); ++node) {
        CHECK(own.position(node) == shipped.position(node));
        CHECK(own.velocity(node) == shipped.velocity(node));
      }
      for (SpringIndex spring = 0; spring < own.spring_count(); ++spring)
        CHECK(own.internal_states(spring) == shipped.internal_states(spring));
      CHECK(own.position(5) !=
            run(swinging({"exponential", {{"stiffness", 61.0}, {"exponent", 3.0}}}, "@own"), host, single_sweep())
                .position(5));
    }
  }
  // Which of the two neurons by default? None of the networks above asks, because their nodes say it.
  Network unclear = swinging(laws[0], "@own");
  unclear.add_node(point({9, 9, 9}));
  CHECK_THROWS_WITH(run(unclear, host, single_sweep()),
                    doctest::Contains("2 plugins have a neuron 'point_mass': say which"));
  CHECK(broken > 0);  // the margin of the host's law is asked
}

namespace {

// Steps exactly at a constant length, with a relaxation time of the object's own.
struct ExactMaxwell : sdk::SpringFunction {
  using has = sdk::Has<sdk::Update>;
  static constexpr const char *id = "exact_maxwell", *summary = "relaxes by an exponential";
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", "of the spring").at_least(0)};
  static constexpr sdk::Parameter states[] = {sdk::number("flow", "m", "of the dashpot").preset(0).learnable(0.01)};
  double relaxation_time;

  static auto force(const auto& e, const auto& p) { return p[0] * (e.elongation() - e.state(0)); }
  auto state_rates(const auto& e, const auto&) const {
    return std::array{(e.elongation() - e.state(0)) / relaxation_time};
  }
  auto update(const auto& e, const auto&, const auto& step) const {
    const auto x = e.elongation();
    return std::array{x + (e.state(0) - x) * exp(-step.duration / relaxation_time)};
  }
};

}  // namespace

TEST_CASE("a law of the host steps its states by its own update") {
  constexpr double k = 40.0, x = 0.2, tau = 0.3, end = 0.6;
  const auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  host->add(spring_function(ExactMaxwell{{}, tau}));
  for (const StateMethod& method : state_methods(1e-9)) {
    CAPTURE(method.name);
    Network net;
    for (const double at : {0.0, 1.0 + x}) {
      springnet::Node node = point({at, 0, 0});
      node.fixed = true;
      net.add_node(node);
    }
    net.add_node(point({0, 0, 5}));
    net.add_spring(0, 1, net.add_material({LawUse{"exact_maxwell", {{"stiffness", k}}}, std::nullopt}), 1.0);
    SimulationOptions options;
    options.time_step = 0.02;
    options.integrator = method.integrator;
    Simulation simulation(net, host, options);
    simulation.advance_to(end);
    CHECK(simulation.tension(0) ==
          doctest::Approx(k * x * std::exp(-end / tau)).epsilon(method.order == 0 ? 1e-6 : 1e-12));
  }
}

namespace {

// Its state leaves the bounds that it declares: with the start, or with the steps.
struct Unbounded : sdk::SpringFunction {
  using has = sdk::Has<sdk::Start, sdk::Update>;
  static constexpr const char *id = "unbounded", *summary = "T = z";
  static constexpr sdk::Parameter states[] = {
      sdk::number("share", "1", "z").preset(0).at_least(0).at_most(1).learnable(0.1)};
  double begin, rate;

  static auto force(const auto& e, const auto&) { return e.state(0) + 0.0 * e.q; }
  auto start(const auto& e, const auto&) const { return std::array{begin + 0.0 * e.q}; }
  auto state_rates(const auto& e, const auto&) const { return std::array{rate + 0.0 * e.q}; }
  auto update(const auto& e, const auto&, const auto& step) const {
    return std::array{e.state(0) + step.duration * rate + 0.0 * e.q};
  }
};

}  // namespace

TEST_CASE("a state out of its bounds, or not a number, ends the run with an error that names law and state") {
  for (const StateMethod& method : state_methods(1e-9)) {
    CAPTURE(method.name);
    ErrorKind kind{};
    const auto message = [&](double begin, double rate) -> std::string {
      const auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
      host->add(spring_function(Unbounded{{}, begin, rate}));
      Network net;
      net.add_node(point({0, 0, 0}));
      net.add_node(point({1, 0, 0}));
      net.add_spring(0, 1, net.add_material({LawUse{"unbounded", {}}, std::nullopt}), 1.0);
      SimulationOptions options;
      options.time_step = 0.02;
      options.integrator = method.integrator;
      try {
        Simulation(net, host, options).advance_to(0.2);
      } catch (const Error& error) {
        kind = error.kind();
        return error.what();
      }
      return {};
    };
    CHECK(message(0, 4.9) == "");  // up to 0.98
    for (const std::string& refused : {message(1.5, 0), message(std::nan(""), 0), message(0, 20)}) {
      CAPTURE(refused);
      CHECK(refused.find("'share'") != std::string::npos);
    }
    CHECK(message(1.5, 0).find("'unbounded' of plugin host failed: its internal state 'share' starts at 1.5") !=
          std::string::npos);
    CHECK(kind == ErrorKind::plugin);
  }
}
