// Relaxation, creep, yield and damage of single springs against closed forms, in every integrator and rule.
#include <cmath>
#include <functional>

#include <doctest/doctest.h>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

// Both ends fixed; node 0 at the origin, node 1 at this length; rest length 1 m.
Network held_at(double length, const LawUse& law) {
  Network net;
  for (const double x : {0.0, length}) {
    Node node = point({x, 0, 0});
    node.fixed = true;
    net.add_node(node);
  }
  net.add_node(point({0, 0, 5}));  // something that moves
  net.add_spring(0, 1, net.add_material({law, std::nullopt}), 1.0);
  return net;
}

struct Held {
  const char* name;
  LawUse law;
  double length;                                 // m
  std::function<double(double)> tension, state;  // at a time, s
};

// Rates that are linear in the state: z(t) = a (1 - exp(-t / T)).
Held relaxing(const char* name, LawUse law, double elongation, double a, double T,
              std::function<double(double)> tension_of_state) {
  const auto state = [a, T](double t) { return a * (1.0 - std::exp(-t / T)); };
  return {name, std::move(law), 1.0 + elongation,
          [state, tension_of_state](double t) { return tension_of_state(state(t)); }, state};
}

std::vector<Held> held_cases() {
  constexpr double k = 40.0, k1 = 25.0, tau = 0.3, x = 0.2, Y = 3.0, H = 15.0, e0 = 0.05, es = 0.4;
  const double aim = (e0 + es) / es * (1.0 - e0 / x);
  return {relaxing("maxwell", {"maxwell", {{"stiffness", k}, {"relaxation_time", tau}}}, x, x, tau,
                   [](double z) { return k * (x - z); }),
          relaxing("standard linear solid",
                   {"standard_linear_solid", {{"stiffness", k}, {"fast_stiffness", k1}, {"relaxation_time", tau}}}, x,
                   x, tau, [](double z) { return k * x + k1 * (x - z); }),
          // (k (x - z) - H z - Y) / (k tau): to z = (k x - Y) / (k + H) in the time k tau / (k + H).
          relaxing("plastic",
                   {"plastic", {{"stiffness", k}, {"yield_tension", Y}, {"hardening", H}, {"relaxation_time", tau}}}, x,
                   (k * x - Y) / (k + H), k * tau / (k + H), [](double z) { return k * (x - z); }),
          relaxing("plastic in compression",
                   {"plastic", {{"stiffness", k}, {"yield_tension", Y}, {"hardening", H}, {"relaxation_time", tau}}},
                   -x, -(k * x - Y) / (k + H), k * tau / (k + H), [](double z) { return k * (-x - z); }),
          relaxing("plastic, elastic range",
                   {"plastic", {{"stiffness", k}, {"yield_tension", 100.0}, {"relaxation_time", tau}}}, x, 0.0, tau,
                   [](double) { return k * x; }),
          relaxing("damaging",
                   {"damaging",
                    {{"stiffness", k}, {"threshold_strain", e0}, {"softening_strain", es}, {"relaxation_time", tau}}},
                   x, aim, tau, [](double d) { return (1.0 - d) * k * x; }),
          relaxing("damaging below the threshold",
                   {"damaging",
                    {{"stiffness", k}, {"threshold_strain", 0.3}, {"softening_strain", es}, {"relaxation_time", tau}}},
                   x, 0.0, tau, [](double) { return k * x; })};
}

}  // namespace

TEST_CASE("states at a constant length follow their closed form") {
  constexpr double end = 0.6, h = 0.02, tau = 0.3;
  for (const Held& each : held_cases()) {
    for (const StateMethod& method : state_methods(1e-10)) {
      CAPTURE(each.name);
      CAPTURE(method.name);
      Simulation simulation = simulate(held_at(each.length, each.law), method.integrator, h);
      simulation.advance_to(end);
      const double state = simulation.internal_states(0).at(0);
      const double size = std::abs(each.state(10.0)) + 1e-3;
      // Of the whole decay exp(-t / T): t/T h/(2 T) of its size in first order, t/T (h/T)^2 / 3 at most in second.
      const double shortest = 40.0 * tau / 55.0, steps = end / shortest, share = h / shortest;
      const double bound = method.order == 0   ? 3e-7
                           : method.order == 1 ? 0.6 * steps * share * std::exp(-steps)
                                               : 0.4 * steps * share * share * std::exp(-steps);
      CHECK(std::abs(state - each.state(end)) <= size * bound);
      CHECK(simulation.tension(0) == doctest::Approx(each.tension(end)).epsilon(1e-12 + 12.0 * bound));
      CHECK(simulation.reaction(0)[0] == doctest::Approx(-simulation.tension(0)).epsilon(1e-12));
    }
  }
}

// Under a constant force f: x = f / k - f k1 / (k (k + k1)) exp(-t k / (tau (k + k1))) in the limit of no mass, and
// with it the solution of a linear system of three equations. Here the limit of slow creep.
TEST_CASE("a standard linear solid creeps to its slow stiffness") {
  constexpr double k = 50.0, k1 = 150.0, tau = 0.2, force = 4.0, mass = 1e-4;
  const LawUse law{"standard_linear_solid", {{"stiffness", k}, {"fast_stiffness", k1}, {"relaxation_time", tau}}};
  // The vibration of the mass, which no closed form has, is taken away by a little damping.
  const Material material{law, LawUse{"linear", {{"damping", 0.05}}}};
  for (const char* name : {"newton", "cvode"}) {
    CAPTURE(name);
    const bool reference = name[0] == 'c';
    const LawUse method = reference ? cvode(1e-9) : recurrent(newton, 1e-9, {{"theta", 0.5}});
    Network net = oscillator(material, mass, 0.0);
    net.add_load({{1}, {force, 0, 0}});
    Simulation simulation = simulate(net, method, 1e-3);
    for (const double t : {0.2, 0.5, 1.0, 3.0}) {
      simulation.advance_to(t);
      const double creep = force / k - force * k1 / (k * (k + k1)) * std::exp(-t * k / (tau * (k + k1)));
      // The damper delays by (damping / k) and the inertia by less.
      CHECK(simulation.position(1)[0] - 1.0 == doctest::Approx(creep).epsilon(2e-3));
    }
    CHECK(simulation.position(1)[0] - 1.0 == doctest::Approx(force / k).epsilon(4e-2));
  }
}

TEST_CASE("a spring that begins relaxed has no tension at its length at the start") {
  const LawUse law{"maxwell", {{"stiffness", 40.0}, {"relaxation_time", 0.3}, {"starts_relaxed", 1.0}}};
  Simulation simulation = simulate(held_at(1.3, law), recurrent(newton, 1e-9), 0.01);
  CHECK(simulation.internal_states(0) == std::vector<double>{0.30000000000000004});
  CHECK(simulation.tension(0) == 0.0);
  simulation.step();
  CHECK(simulation.tension(0) == 0.0);
}

TEST_CASE("a damaged spring breaks when its damage reaches the declared one") {
  constexpr double tau = 0.25, e0 = 0.05, es = 0.2, breaking = 0.6, x = 0.2;
  const double aim = (e0 + es) / es * (1.0 - e0 / x);
  const double expected = -tau * std::log(1.0 - breaking / aim);  // d = aim (1 - exp(-t / tau))
  const LawUse law{"damaging",
                   {{"stiffness", 40.0},
                    {"threshold_strain", e0},
                    {"softening_strain", es},
                    {"relaxation_time", tau},
                    {"breaking_damage", breaking}}};
  for (const StateMethod& method : state_methods(1e-10)) {
    CAPTURE(method.name);
    constexpr double h = 1e-3;
    Simulation simulation = simulate(held_at(1.0 + x, law), method.integrator, h);
    simulation.advance_to(0.5);
    REQUIRE(simulation.events().size() == 1);
    CHECK(simulation.events()[0].kind == Event::Kind::ruptured);
    const bool located = method.order == 0 || method.name == "located";
    CHECK(std::abs(simulation.events()[0].time - expected) <= (located ? 1e-6 : 2.0 * h));
    CHECK_FALSE(simulation.alive(0));
  }
}

TEST_CASE("a relaxation time of a millionth of the step decays, does not ring, and does not go too far for good") {
  constexpr double h = 0.1;
  for (Held& each : held_cases()) {
    each.law.parameters["relaxation_time"] = 1e-6 * h;
    const double state = each.state(1e3), tension = each.tension(1e3);
    for (const StateMethod& method : state_methods(1e-10)) {
      if (method.order == 0) continue;
      CAPTURE(each.name);
      CAPTURE(method.name);
      Simulation simulation = simulate(held_at(each.length, each.law), method.integrator, h);
      for (int step = 0; step < 5; ++step) {
        simulation.step();
        // A step leaves some millionths of the way: (1 - 2 g) / g^2 = 4.8 with two stages.
        CHECK(std::abs(simulation.internal_states(0).at(0) - state) <= 5e-6 * std::abs(state));
        CHECK(std::abs(simulation.tension(0) - tension) <= 40.0 * 0.2 * 1e-5);
      }
    }
  }
}
