// What embedding programs rely on.

#include <doctest/doctest.h>

#include <limits>

#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("positions are a view of the engine's memory") {
  Simulation simulation = simulate(cube(3.0, 2.0, 0.2, 0.081), single_sweep(), 0.05);
  const ConstNodeMap once = simulation.positions(), again = simulation.positions();
  CHECK(once.data() == again.data());
  CHECK(once.cols() == 64);
  simulation.step();
  const auto users = simulation.positions()(Eigen::all, simulation.columns());
  for (NodeIndex k = 0; k < 64; ++k) CHECK(users.col(k) == simulation.position(k));
}

TEST_CASE("steps lie on the grid of the time step; the last one ends at the requested time") {
  Simulation simulation = simulate(cube(3.0, 2.0, 0.2, 0.081), single_sweep(), 0.1);
  for (int i = 1; i <= 1000; ++i) simulation.step();
  CHECK(simulation.time() == 1000 * 0.1);  // no error of a thousand additions
  CHECK(simulation.steps() == 1000);
  CHECK(simulation.advance_to(100.25).steps == 3);
  CHECK(simulation.time() == 100.25);
  simulation.step();
  CHECK(simulation.time() == 100.25 + 0.1);
  CHECK(simulation.advance_to(simulation.time()).steps == 0);
}

TEST_CASE("energy and momentum of a small state, by hand") {
  Network net;
  net.add_node(point({0, 0, 1}, 2.0, {1, 0, 0}));
  net.add_node(point({0, 3, 1}, 4.0, {0, 0, 2}));
  net.add_spring(0, 1, net.add_material(damped(8.0, 0.0)), 2.0);
  net.set_gravity({0, 0, -5});
  const Simulation simulation = simulate(net, cvode(1e-8), 0.1);
  CHECK(simulation.kinetic_energy() == 0.5 * 2.0 * 1.0 + 0.5 * 4.0 * 4.0);
  CHECK(simulation.potential_energy() == doctest::Approx(0.5 * 8.0 * 1.0 + 5.0 * (2.0 + 4.0)).epsilon(1e-15));
  CHECK(simulation.momentum() == Vector3(2, 0, 8));
  CHECK(simulation.angular_momentum() == Vector3(3 * 8, 1 * 2, 0));
  CHECK(simulation.tension(0) == 8.0);
}

TEST_CASE("a network without nodes, and time steps that are not positive and finite, are refused") {
  CHECK_THROWS_AS(simulate(Network{}, cvode(1e-8), 0.1), Error);
  for (const double step : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    CHECK_THROWS_AS(simulate(cube(3.0, 2.0, 0.2, 0.081), cvode(1e-8), step), Error);
}
