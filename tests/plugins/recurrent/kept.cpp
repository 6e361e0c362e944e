// What Newton's method takes from earlier steps may be useless: a step is then as good as without it.
#include <cmath>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/sdk/law.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double step = 0.01;

// A node on a spring whose tension is not finite beyond 0.7 of its length.
Network stiffening() {
  return oscillator(Material{LawUse{"exponential", {{"stiffness", 100}, {"exponent", 1000.0}}}, std::nullopt}, 1.0,
                    0.0);
}

// A linear spring that has no force beyond an elongation of 0.6 m, and no derivatives beyond 0.4 m.
struct Fragile : sdk::SpringFunction {
  static constexpr const char* id = "fragile";
  static constexpr const char* summary = "linear, and gives no force beyond an elongation";
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", "of the spring")};
  static auto force(const auto& e, const auto& p) { return p[0] * e.strain() * e.reference; }
};
using Linear = sdk::ComponentEntry<Fragile>;
const springnet_law& linear_law() { return *static_cast<const springnet_law*>(Linear::value.implementation); }
springnet_status refuse_long_ones(void* context, const springnet_law_batch* batch) {
  const double most = batch->force_by_q != nullptr ? 1.4 : 1.6;  // m, of a length of 1 m
  for (std::uint32_t i = 0; i < batch->count; ++i)
    if (batch->q[i] > most) return SPRINGNET_RECOVERABLE;
  return linear_law().evaluate(context, batch);
}
const springnet_law fragile_law = [] {
  springnet_law law = linear_law();
  law.evaluate = refuse_long_ones;
  return law;
}();
const springnet_component fragile = [] {
  springnet_component component = Linear::value;
  component.implementation = &fragile_law;
  return component;
}();
const springnet_component* const components[] = {&fragile};
const springnet_plugin fragile_plugin = [] {
  springnet_plugin plugin = sdk::PluginEntry<Fragile>::make("test.fragile", "1.0.0", "springnet", "MIT");
  plugin.components = components;
  return plugin;
}();

Simulation at_rest() { return simulate(stiffening(), recurrent(newton, 1e-9), step); }

}  // namespace

TEST_CASE("a step whose guess has no finite forces starts from its start") {
  Simulation simulation = at_rest(), fresh = at_rest();
  for (int i = 0; i < 3; ++i) simulation.step();
  // 0.7 m in a step, or more if the change of velocity is extrapolated, too.
  for (Simulation* each : {&simulation, &fresh}) each->set_velocity(1, {70, 0, 0});
  CHECK(simulation.step().outcome == Outcome::settled);
  CHECK(fresh.step().outcome == Outcome::settled);
  CHECK((simulation.position(1) - fresh.position(1)).norm() <= 1e-12);
}

TEST_CASE("a step whose guess a law refuses, in its forces or derivatives, starts from its start") {
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  REQUIRE(host->add(fragile_plugin));
  // 0.7 m of free motion, then 0.5 m; the spring stops it before 0.4 m.
  for (const double speed : {70.0, 50.0}) {
    CAPTURE(speed);
    const Network net = oscillator(Material{LawUse{"fragile", {{"stiffness", 1e4}}}, std::nullopt}, 1.0, 0.0);
    const SimulationOptions options{.time_step = step, .integrator = recurrent(newton, 1e-9), .threads = 1};
    Simulation simulation(net, host, options);
    for (int i = 0; i < 3; ++i) simulation.step();
    simulation.set_velocity(1, {speed, 0, 0});
    CHECK(simulation.step().outcome == Outcome::settled);
    // x = h v / (1 + h^2 k / m), with h^2 k / m = 1
    CHECK((simulation.position(1) - net.nodes()[1].position).norm() ==
          doctest::Approx(step * speed / 2.0).epsilon(1e-9));
  }
}
