// Each setter against a fresh simulation of a network that is built with the new values.

#include <doctest/doctest.h>

#include "mixed_net.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Forces of some 1e3 N are sums of some twenty; the fresh network may sum them in another order.
constexpr double rounding = 1e-11;  // N
// Both integrate to their tolerances.
constexpr double tolerance = 1e-7;  // m

}  // namespace

TEST_CASE("thousands of changes and cuts leave the forces of a network that is built so") {
  for (const bool regular : {true, false}) {
    CAPTURE(regular);
    MixedNet net(regular);
    Simulation simulation = simulate(net.base(), single_sweep(), 1e-4);
    Dice dice(regular ? 1 : 2);
    for (int i = 0; i < 1500; ++i) {
      net.change(dice, simulation);
      if (i % 50 == 0) simulation.cut({dice.below(static_cast<std::uint32_t>(simulation.spring_count()))});
      if (i % 400 == 399)
        simulation.remove_elements({dice.below(static_cast<std::uint32_t>(simulation.element_count()))});
      if (i % 100 < 98) continue;
      if (i % 100 == 99) simulation.step();
      const Simulation fresh = simulate(net.built(simulation), single_sweep(), 1e-4);
      CHECK(force_difference(simulation, fresh) < rounding);
      CHECK(simulation.kinetic_energy() == doctest::Approx(fresh.kinetic_energy()).epsilon(1e-13));
      CHECK(simulation.live_spring_count() == fresh.spring_count());
    }
    for (SpringIndex s = 0; s < net.values.stiffness.size(); ++s) {
      CHECK(simulation.parameter(s, ComponentKind::spring_function, "stiffness") == net.values.stiffness[s]);
      CHECK(simulation.rest_length(s) == net.values.rest_length[s]);
    }
    for (ElementIndex e = 0; e < net.values.bending.size(); ++e) {
      CHECK(simulation.element_parameter(e, ComponentKind::spring_function, "stiffness") == net.values.bending[e]);
      CHECK(simulation.reference(e) == net.values.reference[e]);
    }
    for (NodeIndex k = 0; k < net.values.drag.size(); ++k) {
      CHECK(simulation.neuron_parameter(k, "drag") == net.values.drag[k]);
      CHECK(simulation.mass(k) == net.values.mass[k]);
    }
  }
}

TEST_CASE("changed values move the network in every integrator as one that is built with them") {
  for (const auto& [integrator, step] : all_integrators()) {
    CAPTURE(integrator.id);
    if (const auto update = integrator.parameters.find("update"); update != integrator.parameters.end())
      CAPTURE(update->second);
    MixedNet net(true, 3);
    Simulation simulation = simulate(net.base(), integrator, step);
    Dice dice(3);
    for (int round = 0; round < 3; ++round) {
      for (int i = 0; i < 4; ++i) simulation.step();
      for (int i = 0; i < 6; ++i) net.change(dice, simulation);
      Simulation fresh = simulate(net.built(simulation), integrator, step);
      CHECK(force_difference(simulation, fresh) < rounding);
      for (int i = 0; i < 4; ++i) {
        simulation.step();
        fresh.step();
      }
      CHECK(distance(simulation, fresh) < tolerance);
      CHECK(force_difference(simulation, fresh) < 1e-4);
    }
  }
}

TEST_CASE("where the layout is the same the bits are") {
  MixedNet net(false);
  Simulation simulation = simulate(net.base(), recurrent(synchronous, 1e-9), 0.001);
  Network built = net.base();
  Dice dice(5);
  std::vector<SpringIndex> springs;
  std::vector<double> lengths;
  for (SpringIndex s = 0; s < net.values.stiffness.size(); s += 3) {
    springs.push_back(s);
    lengths.push_back(dice.between(0.9, 1.5));
    built.set_rest_length(s, lengths.back());
  }
  simulation.set_rest_lengths(springs, lengths);
  Simulation fresh = simulate(built, recurrent(synchronous, 1e-9), 0.001);
  for (int i = 0; i < 20; ++i) {
    CHECK(force_difference(simulation, fresh) == 0.0);
    CHECK(distance(simulation, fresh) == 0.0);
    simulation.step();
    fresh.step();
  }
}

TEST_CASE("a law that prepares tables prepares them for the new parameters") {
  Network net;
  const TableValues curve{{"elongations", {-0.1, 0.0, 0.1}}, {"forces", {-1.0, 0.0, 1.0}}};
  const MaterialIndex measured = net.add_material({LawUse{"table", {}, curve}, std::nullopt});
  constexpr NodeIndex pairs = 40;
  for (NodeIndex k = 0; k < pairs; ++k) {
    net.add_node(point({0, double(k), 0}));
    net.add_node(point({1.3, double(k), 0}));
    net.add_spring(2 * k, 2 * k + 1, measured, 1.0);
  }
  Simulation simulation = simulate(net, single_sweep(), 1e-3);
  const auto set = [&](std::vector<SpringIndex> springs, double beyond) {
    simulation.set_parameter(springs, ComponentKind::spring_function, "beyond", {beyond});
  };
  for (int round = 0; round < 5; ++round) {
    set({3, 7, 20}, 1.0);  // constant
    for (SpringIndex s = 0; s < pairs; ++s)
      CHECK(simulation.tension(s) == doctest::Approx(s == 3 || s == 7 || s == 20 ? 1.0 : 3.0).epsilon(1e-12));
    CHECK(simulation.force(7)[0] == doctest::Approx(-1.0).epsilon(1e-12));
    set({3, 7, 20}, 0.0);
    CHECK(simulation.tension(7) == doctest::Approx(3.0).epsilon(1e-12));
    CHECK(simulation.force(7)[0] == doctest::Approx(-3.0).epsilon(1e-12));
  }
}

TEST_CASE("a weakened spring breaks at once, and a node that is removed stays where it is") {
  Network net;
  for (int k = 0; k < 4; ++k) net.add_node(point({1.2 * k, 0, 0}));
  const MaterialIndex brittle =
      net.add_material({LawUse{"rupturing", {{"stiffness", 50.0}, {"strength", 30.0}}}, std::nullopt});
  for (NodeIndex k = 0; k < 3; ++k) net.add_spring(k, k + 1, brittle, 1.0);
  for (const LawUse& integrator : {single_sweep(), cvode(1e-8), LawUse{"verlet", {}}}) {
    Simulation simulation = simulate(net, integrator, 1e-3);
    simulation.step();
    CHECK(simulation.live_spring_count() == 3);
    simulation.set_parameter({1}, ComponentKind::spring_function, "strength", {5.0});
    simulation.step();
    CHECK_FALSE(simulation.alive(1));
    REQUIRE(simulation.events().size() == 1);
    CHECK(simulation.events()[0].kind == Event::Kind::ruptured);
    const Vector3 place = simulation.position(3);
    simulation.remove_nodes({3});
    CHECK_FALSE(simulation.alive(2));
    CHECK(simulation.alive(0));
    simulation.step();
    CHECK(simulation.position(3) == place);
    CHECK(simulation.events().back().kind == Event::Kind::cut);
  }
}
