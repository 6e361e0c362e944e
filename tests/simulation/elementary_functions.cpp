// Laws, elements, motions and loads that need elementary functions: the same bits for every instruction set and number
// of threads.
#include <doctest/doctest.h>

#include <vector>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Exponential springs with power dampers, angles and hinges, a grip and a load that oscillate.
Network everything() {
  Network net;
  const auto soft = net.add_material({LawUse{"exponential", {{"stiffness", 60.0}, {"exponent", 3.0}}},
                                      LawUse{"power", {{"damping", 2.0}, {"exponent", 0.7}, {"linear_below", 1e-6}}}});
  const auto hinge = net.add_material(damped(5.0, 1e-3));
  Lattice lattice;
  lattice.nodes = {16, 16, 16};
  lattice.diagonals = Diagonals::space;
  net.add_lattice("block", lattice, Node{}, soft);
  net.set_gravity({1.0, 2.0, -9.81});
  for (NodeIndex k = 0; k + 300 < 4096; k += 7) {
    net.add_element(Invariant::angle, {k, k + 17, k + 273}, hinge, 1.1);
    net.add_element(Invariant::dihedral, {k, k + 1, k + 17, k + 256}, hinge, 0.3);
  }
  std::vector<NodeIndex> grip, loaded;
  for (NodeIndex k = 0; k < 64; ++k) {
    grip.push_back(k);
    loaded.push_back(4095 - k);
  }
  Motion motion;
  motion.amplitude = {0.02, -0.01, 0.1};
  motion.frequency = 0.7;
  motion.phase = 0.3;
  net.add_move({grip, motion});
  Load load;
  load.nodes = loaded;
  load.force = {0.3, 0.0, 30.0};
  load.course.frequency = 1.3;
  net.add_load(load);
  return net;
}

Eigen::MatrixXd run(const Network& net, const LawUse& integrator, unsigned threads, InstructionSet set) {
  SimulationOptions options;
  options.time_step = 5e-4;
  options.integrator = integrator;
  options.threads = threads;
  options.instruction_set = set;
  Simulation simulation(net, plugins(), options);
  for (int i = 0; i < 40; ++i) simulation.step();
  Eigen::MatrixXd result(6, simulation.positions().cols());
  result << simulation.positions(), simulation.velocities();
  return result;
}

}  // namespace

TEST_CASE("elementary functions: the same bits for every instruction set and number of threads") {
  const Network net = everything();
  for (const LawUse& integrator :
       {single_sweep(), recurrent(newton, 1e-6), LawUse{"verlet", {}}, generalized_alpha()}) {
    CAPTURE(integrator.id);
    const Eigen::MatrixXd one = run(net, integrator, 1, InstructionSet::generic);
    CHECK(one.allFinite());
    CHECK(run(net, integrator, 1, InstructionSet::best) == one);
    CHECK(run(net, integrator, 3, InstructionSet::best) == one);
#if defined(__x86_64__) && !defined(SPRINGNET_GENERIC_ONLY)
    if (__builtin_cpu_supports("avx2")) CHECK(run(net, integrator, 2, InstructionSet::avx2) == one);
#endif
  }
}
