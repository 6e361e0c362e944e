// Changes in saved states: a restored simulation goes on with the same bits, and an earlier state takes changes back.

#include <string>

#include <doctest/doctest.h>

#include "mixed_net.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("changes are saved, and taken back by an earlier state") {
  for (const bool regular : {true, false})
    for (const auto& [integrator, step] : all_integrators()) {
      CAPTURE(integrator.id);
      CAPTURE(regular);
      MixedNet net(regular, 3);
      Dice dice(11);
      Simulation simulation = simulate(net.base(), integrator, step), plain = simulate(net.base(), integrator, step);
      simulation.step();
      plain.step();
      const std::string early = simulation.save();
      static_cast<void>(plain.save());
      for (int i = 0; i < 12; ++i) net.change(dice, simulation);
      simulation.cut({1, 5});
      simulation.step();
      net.change(dice, simulation);
      const std::string changed = simulation.save();
      Simulation other = simulate(net.base(), integrator, step);
      other.restore(changed);
      for (int i = 0; i < 4; ++i) {
        CHECK(force_difference(simulation, other) == 0.0);
        CHECK(distance(simulation, other) == 0.0);
        CHECK(simulation.kinetic_energy() == other.kinetic_energy());
        simulation.step();
        other.step();
      }
      for (SpringIndex s = 0; s < net.values.stiffness.size(); ++s) {
        CHECK(other.parameter(s, ComponentKind::spring_function, "stiffness") == net.values.stiffness[s]);
        CHECK(other.rest_length(s) == net.values.rest_length[s]);
      }
      // Changes of a restored one, and a state before all of them.
      net.change(dice, other);
      for (int i = 0; i < 2; ++i) other.step();
      other.restore(early);
      CHECK(other.parameter(0, ComponentKind::spring_function, "stiffness") == 300.0);
      CHECK(other.mass(3) == 1.0);
      for (int i = 0; i < 3; ++i) {
        CHECK(distance(plain, other) == 0.0);
        plain.step();
        other.step();
      }
    }
}

TEST_CASE("tables that were prepared anew are so after restoring") {
  Network net;
  const TableValues curve{{"elongations", {-0.1, 0.0, 0.1}}, {"forces", {-1.0, 0.0, 1.0}}};
  const MaterialIndex measured = net.add_material({LawUse{"table", {}, curve}, std::nullopt});
  for (NodeIndex k = 0; k < 30; ++k) {
    net.add_node(point({0, double(k), 0}));
    net.add_node(point({1.3, double(k), 0}));
    net.add_spring(2 * k, 2 * k + 1, measured, 1.0);
  }
  Simulation own = simulate(net, single_sweep(), 1e-3), other = simulate(net, single_sweep(), 1e-3);
  const std::string early = own.save();
  own.set_parameter({3, 7, 20}, ComponentKind::spring_function, "beyond", {1.0});
  own.step();
  other.restore(own.save());
  CHECK(other.tension(7) == doctest::Approx(1.0).epsilon(1e-3));
  for (int i = 0; i < 5; ++i) {
    CHECK(distance(own, other) == 0.0);
    own.step();
    other.step();
  }
  other.restore(early);
  CHECK(other.tension(7) == doctest::Approx(3.0).epsilon(1e-9));
}
