// What all outputs share: the simulation's own numbers, computed on demand and only once.
#include "record/record.hpp"

#include <doctest/doctest.h>

#include "nets.hpp"

using namespace springnet;

namespace {

// A chain that swings over a plane which its end touches, with an angle in the middle. Nodes are renumbered.
Network swinging() {
  Network net = testing::chain(5, {0, 0, 0.5}, {0.3, 0.1, -0.1}, testing::damped(50.0, 0.3), 0.7);
  net.fix(0);
  net.set_gravity({0.1, -0.2, -9.81});
  net.add_plane({"floor", Vector3(0, 0, 0.1), Vector3::UnitZ()});
  net.add_element(Invariant::angle, {0, 1, 2},
                  net.add_material({LawUse{"linear", {{"stiffness", 2.0}}}, std::nullopt}));
  return net;
}

}  // namespace

TEST_CASE("a record has the simulation's numbers, by the user's nodes and springs") {
  const Network net = swinging();
  Simulation simulation = testing::simulate(net, testing::recurrent(testing::newton, 1e-9), 0.01);
  Record record(net);
  for (int step = 0; step < 20; ++step) {
    simulation.step();
    record.take(simulation);
    CHECK(record.time() == simulation.time());
    for (NodeIndex node = 0; node < 5; ++node) {
      const auto column = static_cast<Eigen::Index>(node);
      CHECK(record.positions().col(column) == simulation.position(node));
      CHECK(record.velocities().col(column) == simulation.velocity(node));
      CHECK(record.forces().col(column) == simulation.force(node));
    }
    for (SpringIndex spring = 0; spring < 4; ++spring) {
      CHECK(record.lengths()[spring] == (simulation.position(spring + 1) - simulation.position(spring)).norm());
      CHECK(record.tensions()[spring] == doctest::Approx(simulation.tension(spring)).epsilon(1e-12));
    }
    std::vector<double> energies;
    simulation.spring_energies(energies);
    CHECK(record.energies() == energies);
    CHECK(record.element_value(0) == simulation.element_value(0));
    REQUIRE(record.surface_loads().size() == 1);
    CHECK(record.surface_loads()[0].force == simulation.surface_force(0));
    CHECK(record.surface_loads()[0].nodes == simulation.nodes_touching(0));
    CHECK(record.kinetic_energy() == simulation.kinetic_energy());
    CHECK(record.potential_energy() == simulation.potential_energy());
  }
  CHECK(simulation.nodes_touching(0) > 0);
}

TEST_CASE("a record computes each quantity once") {
  const Network net = swinging();
  Simulation simulation = testing::simulate(net, testing::recurrent(testing::newton, 1e-9), 0.01);
  Record record(net);
  record.take(simulation);
  const Record::Vectors positions = record.positions(), velocities = record.velocities(), forces = record.forces();
  const std::vector<double> lengths = record.lengths(), tensions = record.tensions(), energies = record.energies();
  const double angle = record.element_value(0), kinetic = record.kinetic_energy();
  const double potential = record.potential_energy();
  const Vector3 load = record.surface_loads()[0].force;
  for (int step = 0; step < 20; ++step) simulation.step();
  // The simulation is not queried again, although its state has changed.
  CHECK(record.positions() == positions);
  CHECK(record.velocities() == velocities);
  CHECK(record.forces() == forces);
  CHECK(record.lengths() == lengths);
  CHECK(record.tensions() == tensions);
  CHECK(record.energies() == energies);
  CHECK(record.element_value(0) == angle);
  CHECK(record.kinetic_energy() == kinetic);
  CHECK(record.potential_energy() == potential);
  CHECK(record.surface_loads()[0].force == load);
  record.take(simulation);
  CHECK(record.positions() != positions);
  CHECK(record.velocities() != velocities);
  CHECK(record.forces() != forces);
  CHECK(record.lengths() != lengths);
  CHECK(record.tensions() != tensions);
  CHECK(record.energies() != energies);
  CHECK(record.element_value(0) != angle);
  CHECK(record.kinetic_energy() != kinetic);
  CHECK(record.potential_energy() != potential);
  CHECK(record.surface_loads()[0].force != load);
}
