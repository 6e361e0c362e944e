// Energy that laws with internal state dissipate: never negative, and what the network loses.
#include <algorithm>
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

struct NamedLaw {
  const char* name;
  LawUse use;
};
const std::vector<NamedLaw>& laws() {
  static const std::vector<NamedLaw> all{
      {"maxwell", {"maxwell", {{"stiffness", 40.0}, {"relaxation_time", 0.2}}}},
      {"standard linear solid",
       {"standard_linear_solid", {{"stiffness", 20.0}, {"fast_stiffness", 40.0}, {"relaxation_time", 0.2}}}},
      {"plastic",
       {"plastic", {{"stiffness", 40.0}, {"yield_tension", 1.0}, {"hardening", 10.0}, {"relaxation_time", 0.02}}}},
      {"damaging",
       {"damaging",
        {{"stiffness", 40.0}, {"threshold_strain", 0.02}, {"softening_strain", 2.0}, {"relaxation_time", 0.1}}}}};
  return all;
}

}  // namespace

TEST_CASE("a free network with internal states only loses energy") {
  for (const NamedLaw& law : laws()) {
    for (const StateMethod& method : state_methods(1e-11)) {
      if (method.name == "single sweep" || method.name == "synchronous trapezoidal" || method.order == 2) continue;
      CAPTURE(law.name);
      CAPTURE(method.name);
      Simulation simulation = simulate(oscillator({law.use, std::nullopt}, 1.0, 0.15, 0.5), method.integrator, 0.01);
      const auto energy = [&] { return simulation.kinetic_energy() + simulation.potential_energy(); };
      double before = energy();
      for (int step = 0; step < 150; ++step) {
        simulation.step();
        const double now = energy();
        CHECK(now <= before + 1e-8);
        before = now;
      }
    }
  }
}

// The loop of tension over elongation between -a and a, driven slowly: Y has to be overcome all along the plastic way,
// 2 (k a - Y) / (k + H) there and back, so that a cycle takes 4 Y (k a - Y) / (k + H).
TEST_CASE("the hysteresis loop of slow plastic flow has the area of its closed form") {
  constexpr double k = 40.0, Y = 2.0, H = 10.0, a = 0.2, period = 8.0;
  const LawUse law{"plastic", {{"stiffness", k}, {"yield_tension", Y}, {"hardening", H}, {"relaxation_time", 1e-5}}};
  Network net;
  Node wall = point(Vector3::Zero());
  wall.fixed = true;
  net.add_node(wall);
  net.add_node(point({1.0, 0, 0}));
  net.add_spring(0, 1, net.add_material({law, std::nullopt}), 1.0);
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    Simulation simulation = simulate(net, recurrent(newton, 1e-9, {{"theta", theta}}), 0.01);
    // There and back along straight lines: 0, a, -a, a.
    double work = 0.0, before = 0.0, at = 0.0;
    const auto go = [&](double to, double time) {
      simulation.move_node(1, {1.0 + to, 0, 0}, time);
      while (simulation.time() < time - 1e-9) {
        simulation.step();
        const double x = simulation.position(1)[0] - 1.0, tension = simulation.tension(0);
        work += 0.5 * (tension + before) * (x - at);
        at = x;
        before = tension;
      }
    };
    go(a, period);
    go(-a, 2.0 * period);
    go(a, 3.0 * period);
    work = 0.0;
    go(-a, 4.0 * period);
    go(a, 5.0 * period);
    // The kinks of the loop are cut off by a share of a step, h / period of a straight line.
    CHECK(work == doctest::Approx(4.0 * Y * (2.0 * (k * a - Y)) / (k + H) / 2.0).epsilon(5e-3));
  }
}

// A faster drive of a viscoplastic spring meets more resistance: at a constant rate v of yielding s = Y + k tau v.
TEST_CASE("viscoplastic flow depends on its rate") {
  constexpr double k = 40.0, Y = 2.0, tau = 0.1;
  const LawUse law{"plastic", {{"stiffness", k}, {"yield_tension", Y}, {"relaxation_time", tau}}};
  for (const double speed : {0.01, 0.1, 1.0}) {
    CAPTURE(speed);
    Network net = oscillator({law, std::nullopt}, 1.0, 0.0);
    Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.01);
    const double time = 1.0 + 2.0 * Y / (k * speed);
    simulation.move_node(1, {1.0 + speed * time, 0, 0}, time);
    simulation.advance_to(time);
    CHECK(simulation.tension(0) == doctest::Approx(Y + k * tau * speed).epsilon(1e-4));
  }
}
