// A law whose state at the end of a step is not found where the step is too large.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include <doctest/doctest.h>

#include <springnet/host_laws.hpp>
#include <springnet/output.hpp>

#include "csv.hpp"
#include "facts.hpp"
#include "methods.hpp"
#include "temporary_folder.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;
namespace sdk = springnet::sdk;

// T = k x + z, z' = 1 + z^2: z = tan(t + arctan z(0)), up to where that is a pole. An implicit stage
// Z = b + w (1 + Z^2) has a solution where 4 w (b + w) is at most 1.
struct Runaway : sdk::SpringFunction {
  using has = sdk::Has<sdk::Start>;
  static constexpr const char *id = "runaway", *summary = "T = k x + z, z' = 1 + z^2";
  static constexpr bool adds_power = true, not_zero_at_rest = true;
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", "k").at_least(0)};
  static constexpr sdk::Parameter states[] = {sdk::number("tangent", "1", "z").preset(0).learnable(1)};
  double begin;

  static auto force(const auto& e, const auto& p) { return p[0] * e.elongation() + e.state(0); }
  static auto state_rates(const auto& e, const auto&) { return std::array{1.0 + e.state(0) * e.state(0)}; }
  auto start(const auto& e, const auto&) const { return std::array{begin + 0.0 * e.q}; }
};

std::shared_ptr<const PluginHost> with_runaway(double begin) {
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  host->add(spring_function(Runaway{{}, begin}));
  return host;
}

// Spring 0 is linear, spring 1 has the law.
Scene scene_with(const PluginHost& host, const LawUse& integrator, double time_step, double duration) {
  Scene scene;
  Network& net = scene.network;
  net.add_node(point({0, 0, 0}));
  net.fix(0);
  net.add_node(point({1, 0, 0}));
  net.add_node(point({2, 0, 0}));
  net.add_spring(0, 1, net.add_material(damped(4.0, 0.5)), 1.0);
  net.add_spring(1, 2, net.add_material({LawUse{"runaway", {{"stiffness", 4.0}}}, std::nullopt}), 1.0);
  scene.duration = duration;
  scene.options.time_step = time_step;
  scene.options.threads = 1;
  scene.options.integrator = integrator;
  scene.output.states = true;
  scene.output.law_states = find_law_states(net, host);
  scene.output.view = false;
  return scene;
}

LawUse dividing(LawUse integrator) {
  integrator.parameters["unsettled"] = on_unsettled_adapt;
  return integrator;
}

// The stage's solution next to its base, if there is one.
std::optional<double> stage(double base, double weight) {
  const double radicand = 1.0 - 4.0 * weight * (base + weight);
  if (radicand < 0.0) return std::nullopt;
  return 2.0 * (base + weight) / (1.0 + std::sqrt(radicand));
}

std::optional<double> stepped(int order, double z, double h) {
  if (order == 1) return stage(z, h);
  const std::optional<double> whole = stage(z, h), half = stage(z, 0.5 * h);
  const std::optional<double> both = half ? stage(*half, 0.5 * h) : std::nullopt;
  if (!whole || !both) return std::nullopt;
  return 2.0 * *both - *whole;
}

// Divided into halves as far as it takes.
double divided(int order, double z, double h) {
  if (const std::optional<double> whole = stepped(order, z, h)) return *whole;
  return divided(order, divided(order, z, 0.5 * h), 0.5 * h);
}

}  // namespace

TEST_CASE("adapt divides steps at whose end the state of a law does not exist, from the first step on") {
  constexpr double begin = 3.0, h = 0.2;
  for (const StateMethod& method : state_methods(1e-9)) {
    CAPTURE(method.name);
    if (method.integrator.id != "recurrent") continue;
    REQUIRE_FALSE(stepped(method.order, begin, h));
    const auto host = with_runaway(begin);
    const Scene scene = scene_with(*host, dividing(method.integrator), h, h);
    Simulation simulation(scene.network, host, scene.options);
    const StepReport report = simulation.step();
    CHECK(report.substeps >= 2);
    CHECK(simulation.time() == h);
    CHECK(simulation.internal_states(1).at(0) == doctest::Approx(divided(method.order, begin, h)).epsilon(1e-9));
    CHECK(simulation.tension(1) ==
          doctest::Approx(4.0 * ((simulation.position(2) - simulation.position(1)).norm() - 1.0) +
                          simulation.internal_states(1)[0]));
  }
}

TEST_CASE("without adapt the run ends with an error that names law, spring and time, and keeps what it has") {
  constexpr double h = 0.1, duration = 1.5;
  const auto host = with_runaway(0.0);
  for (const StateMethod& method : state_methods(1e-9)) {
    CAPTURE(method.name);
    if (method.integrator.id == "generalized_alpha") continue;  // divides its steps
    const TemporaryFolder folder;
    const RunSummary summary =
        run_scene(scene_with(*host, method.integrator, h, duration), host, {folder.path(), "runaway", {}});
    const Csv table = read_csv(folder.path() / "states.csv");
    const Csv trajectory = read_csv(folder.path() / "trajectory.csv");
    if (method.order == 0) {  // cvode's own steps are as small as it takes
      CHECK_FALSE(summary.failure);
      CHECK(table.number(table.rows.size() - 1, 5) == doctest::Approx(std::tan(duration)).epsilon(1e-6));
      continue;
    }
    std::size_t steps = 0;
    double z = 0.0;
    for (; const std::optional<double> next = stepped(method.order, z, h); ++steps) {
      REQUIRE(steps + 1 < table.rows.size());
      CHECK(table.number(steps, 5) == doctest::Approx(z).epsilon(1e-9));
      z = *next;
    }
    CHECK(table.rows.size() == steps + 1);
    CHECK(table.number(steps, 5) == doctest::Approx(z).epsilon(1e-9));
    CHECK(trajectory.rows.size() == 3 * (steps + 1));
    CHECK(summary.failure);
    CAPTURE(summary.error);
    CHECK(has_all(summary.error, {"'runaway'", "spring 1", "internal state"}));
    CHECK(summary.simulated == doctest::Approx(static_cast<double>(steps) * h));

    if (method.integrator.id != "recurrent") continue;
    const TemporaryFolder whole;
    const RunSummary adapted =
        run_scene(scene_with(*host, dividing(method.integrator), h, static_cast<double>(steps + 1) * h), host,
                  {whole.path(), "runaway", {}});
    CAPTURE(adapted.error);
    CHECK_FALSE(adapted.failure);
    const Csv states = read_csv(whole.path() / "states.csv");
    REQUIRE(states.rows.size() == steps + 2);
    CHECK(states.number(steps + 1, 5) == doctest::Approx(divided(method.order, z, h)).epsilon(1e-8));
  }
}
