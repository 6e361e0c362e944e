// What steps of Newton's method cost, in sweeps and iterations: not time, which tests do not measure.
#include <doctest/doctest.h>

#include "nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

// A block of so many nodes a side, 1 kg each, that goes on with a velocity of 1 m/s.
Network block_of(NodeIndex side, double stiffness) {
  Network net;
  Lattice lattice;
  lattice.nodes = {side, side, side};
  lattice.diagonals = Diagonals::face;
  Node node;
  node.velocity = {1.0, 0.2, 0.0};
  net.add_lattice("block", lattice, node, net.add_material(damped(stiffness, 2.0)));
  return net;
}

double sweeps_of(const Network& net, double step) {
  Simulation simulation = simulate(net, recurrent(newton, 1e-6), step);
  for (int k = 0; k < 20; ++k) simulation.step();
  const auto before = static_cast<double>(simulation.sweeps());
  for (int k = 0; k < 20; ++k) simulation.step();
  return (static_cast<double>(simulation.sweeps()) - before) / 20.0;
}

}  // namespace

TEST_CASE("a body that slides costs hardly more sweeps than one that flies") {
  Network flying = block_of(4, 2000.0);
  flying.set_gravity({0, 0, -0.5});
  Network sliding = flying;
  Plane floor;
  floor.friction = {Friction::Kind::coulomb, 0.05};
  sliding.add_plane(floor);
  // Measured: 1 and 1.8; 3 where the nodes that slide start from their last velocities.
  CHECK(sweeps_of(sliding, 0.02) <= sweeps_of(flying, 0.02) + 1.4);
}

TEST_CASE("moderately stiff solids take few iterations") {
  Network net = block_of(8, 2e4);
  for (NodeIndex k = 0; k < 64; ++k) net.fix(8 * k);
  net.set_gravity({0, 0, -10});
  Simulation simulation = simulate(net, recurrent(newton, 1e-6), 0.04);
  for (int k = 0; k < 20; ++k) simulation.step();
  // Measured: 742; 1928 with the nodes' own blocks alone.
  CHECK(simulation.statistics().at("krylov_iterations") < 1000.0);
}
