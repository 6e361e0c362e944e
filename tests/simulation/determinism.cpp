// The same bits for every number of threads, and for simulations that run at once.

#include <doctest/doctest.h>

#include <thread>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Network soft_block() {
  Lattice lattice;
  lattice.nodes = {24, 24, 48};  // four units of nodes
  lattice.diagonals = Diagonals::space;
  lattice.origin = {0, 0, 0.01};
  Network net;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(50.0, 1.0)));
  net.set_gravity({0.3, 0, -1.0});
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  return net;
}

Eigen::MatrixXd run(const Network& net, const LawUse& integrator, unsigned threads, InstructionSet set, int steps) {
  SimulationOptions options;
  options.time_step = 0.02;
  options.integrator = integrator;
  options.threads = threads;
  options.instruction_set = set;
  Simulation simulation(net, plugins(), options);
  CHECK(simulation.threads() == threads);
  for (int i = 0; i < steps; ++i) simulation.step();
  CHECK(simulation.events().size() >= 24 * 24);  // it lies on the floor
  Eigen::MatrixXd result(6, simulation.positions().cols());
  result << simulation.positions(), simulation.velocities();
  return result;
}

}  // namespace

TEST_CASE("bit-identical motion for 1, 2, 3 and 4 threads") {
  const Network net = soft_block();
  for (const LawUse& integrator : {single_sweep(), recurrent(synchronous, 1e-6)}) {
    const Eigen::MatrixXd one = run(net, integrator, 1, InstructionSet::best, 12);
    for (const unsigned threads : {2u, 3u, 4u}) CHECK(run(net, integrator, threads, InstructionSet::best, 12) == one);
    CHECK(run(net, integrator, 1, InstructionSet::generic, 12) == one);
  }
}

TEST_CASE("several simulations at once do not affect each other") {
  const Network net = cube(3.0, 2.0, 0.2, 0.081);
  const auto course = [&net](const LawUse& integrator) {
    Simulation simulation = simulate(net, integrator, 0.05);
    simulation.advance_to(3.0);
    return Eigen::MatrixXd(simulation.positions());
  };
  const LawUse integrators[] = {recurrent(synchronous, 1e-8), recurrent(wavefront, 1e-8), cvode(1e-8)};
  std::vector<Eigen::MatrixXd> alone, together(3);
  for (const LawUse& integrator : integrators) alone.push_back(course(integrator));
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < 3; ++i) threads.emplace_back([&, i] { together[i] = course(integrators[i]); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < 3; ++i) CHECK(together[i] == alone[i]);
}

TEST_CASE("renumbering is hidden: the user's numbers give the same motion to rounding") {
  const Network net = cube(3.0, 2.0, 0.2, 0.081);
  SimulationOptions options;
  options.time_step = 0.05;
  options.integrator = recurrent(synchronous, 1e-10);
  options.renumber = false;
  Simulation plain(net, plugins(), options);
  options.renumber = true;
  Simulation renumbered(net, plugins(), options);
  plain.advance_to(2.0);
  renumbered.advance_to(2.0);
  for (NodeIndex k = 0; k < 64; ++k) {
    CHECK(plain.columns()[k] == k);
    // Sums in another order, over 40 steps of a dissipative system.
    CHECK((plain.position(k) - renumbered.position(k)).norm() <= 1e-12);
    CHECK(renumbered.positions().col(renumbered.columns()[k]) == renumbered.position(k));
  }
}
