// All update rules and integrators agree on elements; results do not depend on threads.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "../random_nets/plain.hpp"
#include "bodies.hpp"
#include "layers/layout.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

PlainState state_of(const Simulation& simulation) {
  PlainState state;
  for (NodeIndex k = 0; k < simulation.node_count(); ++k) {
    state.position.push_back(simulation.position(k));
    state.velocity.push_back(simulation.velocity(k));
  }
  return state;
}

// A sphere of many nodes with hinges and areas besides its filling, in units of more than one thread.
Network bladder(int levels) {
  const TriangleMesh mesh = icosphere(levels, 1.0);
  Network net = filled(mesh, 1e-3, 20.0, 40.0, 0.01);
  const MaterialIndex skin = net.add_material(damped(5.0, 0.01)), hinge = net.add_material(damped(1e-3, 1e-5));
  std::map<std::pair<NodeIndex, NodeIndex>, NodeIndex> apex;
  const auto for_each_side = [&](auto&& what) {
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
      for (std::size_t k = 0; k < 3; ++k)
        what(mesh.triangles[t + k], mesh.triangles[t + (k + 1) % 3], mesh.triangles[t + (k + 2) % 3]);
  };
  for_each_side([&](NodeIndex a, NodeIndex b, NodeIndex c) { apex[{a, b}] = c; });
  for_each_side([&](NodeIndex a, NodeIndex b, NodeIndex c) {
    if (a < b) net.add_element(Invariant::dihedral, {a, b, c, apex.at({b, a})}, hinge);
  });
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    net.add_element(Invariant::area, {mesh.triangles[t], mesh.triangles[t + 1], mesh.triangles[t + 2]}, skin);
  net.fix(0);
  net.add_load({{5, 6, 7}, {0.4, -0.3, 0.2}});
  return net;
}

}  // namespace

TEST_CASE("every update rule settles at the fixed point of the equation of motion, by independent formulas") {
  for (const unsigned seed : {1u, 2u, 3u}) {
    Network net = all_kinds(seed);
    if (seed == 2) net.add_rigid(16, 21);  // two nodes of the surface
    constexpr double step = 0.02, tolerance = 1e-10;
    for (const double rule : {synchronous, wavefront, block, coloured, newton, automatic}) {
      CAPTURE(seed);
      CAPTURE(rule);
      Simulation simulation = simulate(net, recurrent(rule, tolerance), step);
      for (int i = 0; i < 3; ++i) {
        const PlainState before = state_of(simulation);
        REQUIRE(simulation.step().outcome == Outcome::settled);
        const PlainState after = state_of(simulation);
        const std::vector<Vector3> forces = plain_forces(net, after, std::vector<bool>(net.springs().size(), true),
                                                         std::vector<bool>(net.elements().size(), true));
        std::vector<Vector3> residual;
        for (std::size_t k = 0; k < forces.size(); ++k)
          residual.push_back(net.nodes()[k].mass * (after.velocity[k] - before.velocity[k]) / step - forces[k]);
        residual = without_tensions(net, after, std::vector<bool>(forces.size(), true), residual);
        // A rule may stop with a residual of some times its tolerance, as it is the last difference that it bounds; a
        // synchronous rule that settles by a factor near 1 a sweep by more.
        for (const Vector3& r : residual) CHECK(r.norm() < 100.0 * tolerance);
      }
    }
  }
}

TEST_CASE("first and second order against CVODE") {
  const Network net = all_kinds(4);
  constexpr double until = 0.2;
  Simulation reference = simulate(net, cvode(1e-11), 0.05);
  reference.advance_to(until);
  const auto error = [&](const LawUse& integrator, double step) {
    Simulation simulation = simulate(net, integrator, step);
    simulation.advance_to(until);
    double sum = 0.0;
    for (NodeIndex k = 0; k < simulation.node_count(); ++k)
      sum += (simulation.position(k) - reference.position(k)).squaredNorm();
    return std::sqrt(sum);
  };
  const auto ratio = [&](const LawUse& integrator, double step) {
    return error(integrator, step) / error(integrator, 0.5 * step);
  };
  // Up to the next order in the step.
  CHECK(ratio(recurrent(newton, 1e-11), 0.001) == doctest::Approx(2.0).epsilon(0.1));
  CHECK(ratio(recurrent(block, 1e-11, {{"theta", 0.5}}), 0.002) == doctest::Approx(4.0).epsilon(0.1));
  CHECK(ratio(generalized_alpha(), 0.001) == doctest::Approx(4.0).epsilon(0.15));
  CHECK(ratio({"verlet", {}}, 0.001) > 1.8);  // first order at least: forces depend on velocities
}

TEST_CASE("results are bitwise equal for every number of threads and every instruction set") {
  const Network net = bladder(5);  // 10,242 nodes: more than one unit
  REQUIRE(net.nodes().size() > 8192);
  struct Run {
    LawUse integrator;
    int steps;
  };
  for (const Run& run : {Run{single_sweep(), 3}, Run{recurrent(coloured, 0.0, {{"sweeps", 2}}), 1}}) {
    std::vector<Eigen::MatrixXd> results;
    for (const unsigned threads : {1u, 2u, 3u}) {
      SimulationOptions options;
      options.time_step = 1e-3;
      options.integrator = run.integrator;
      options.threads = threads;
      if (threads == 3) options.instruction_set = InstructionSet::generic;
      Simulation simulation(net, plugins(), options);
      CHECK((simulation.threads() > 1) == (threads > 1));
      for (int i = 0; i < run.steps; ++i) simulation.step();
      results.emplace_back(simulation.positions());
      results.back().conservativeResize(6, Eigen::NoChange);
      results.back().bottomRows(3) = simulation.velocities();
    }
    CHECK(results[0] == results[1]);
    CHECK(results[0] == results[2]);
  }
}

TEST_CASE("a filled surface does not make all of its nodes neighbours, and Newton's method steps it") {
  const Network net = bladder(3);  // 642 nodes
  const layers::Layout layout(net, *plugins(), true);
  // 6 neighbours round a node, and 6 tips of hinges beyond them.
  CHECK(layout.neighbours().size() <= 13 * net.nodes().size());
  for (const double step : {0.05, 1.0}) {
    Simulation simulation = simulate(net, recurrent(newton, 1e-9), step);
    CHECK(simulation.step().outcome == Outcome::settled);
  }
  // The filling is hard: sets of which all nodes changed the volume at once would not settle.
  Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.01);
  Simulation other = simulate(net, recurrent(coloured, 1e-9), 0.01);
  for (int i = 0; i < 2; ++i) {
    CHECK(simulation.step().outcome == Outcome::settled);
    CHECK(other.step().outcome == Outcome::settled);
  }
  double difference = 0.0;
  for (NodeIndex k = 0; k < simulation.node_count(); ++k)
    difference = std::max(difference, (simulation.position(k) - other.position(k)).norm());
  // A force of the tolerance moves a node by it over m / t_c^2, 1e-10 m a step; sweeps stop some tolerances short.
  CHECK(difference < 1e-7);
}
