// Where a wavefront starts, step by step.
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include "nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

// A string of 9 nodes along x, both ends fixed; node 4 is its middle.
Network string_of_nodes() {
  Network net = chain(9, Vector3::Zero(), Vector3::UnitX(), damped(10.0, 1.0));
  net.fix(0);
  net.fix(8);
  return net;
}

LawUse exactly(double sweeps) { return recurrent(wavefront, 1e-9, {{"sweeps", sweeps}}); }

}  // namespace

TEST_CASE("the start node follows a load that moves between steps") {
  Simulation simulation = simulate(string_of_nodes(), exactly(1), 0.05);
  for (const NodeIndex loaded : {2u, 6u, 1u, 4u, 7u}) {
    CAPTURE(loaded);
    for (NodeIndex k = 0; k < 9; ++k) simulation.set_force(k, k == loaded ? Vector3(0, 5.0, 0) : Vector3::Zero());
    CHECK(simulation.step().start_node == loaded);
  }
}

TEST_CASE("the start node follows a load of the scene as it is switched") {
  Network net = string_of_nodes();
  net.add_load({{3}, {0, 5, 0}, 0.0, 0.1});
  net.add_load({{6}, {0, 5, 0}, 0.1, 0.2});
  Simulation simulation = simulate(net, exactly(1), 0.05);
  for (const std::int64_t expected : {3, 3, 6, 6}) CHECK(simulation.step().start_node == expected);
}

TEST_CASE("the second sweep starts where the force changed most in the first") {
  // Node 3 is pulled. The sweep begins there and moves it; its neighbour 2 is next, and its force changes by all of
  // that movement, and so does that of 4 after it: by symmetry the same, and the lower number is taken.
  Network net = string_of_nodes();
  net.add_load({{3}, {5, 0, 0}});
  Simulation one = simulate(net, exactly(1), 0.05);
  const StepReport first = one.step();
  CHECK(first.start_node == 3);
  CHECK(first.node == 2);
  Simulation two = simulate(net, exactly(2), 0.05);
  CHECK(two.step().start_node == 2);
}

TEST_CASE("no wave starts at a fixed node while another is free") {
  Network net = string_of_nodes();
  net.add_load({{0}, {0, 100, 0}});
  net.add_load({{5}, {0, 1, 0}});
  Simulation simulation = simulate(net, exactly(1), 0.05);
  CHECK(simulation.step().start_node == 5);
}

TEST_CASE("a wave does not start at a fixed node, though its force changed most") {
  // One free node between two walls, pulled up: the wave begins at 1; the force on wall 2 then changes most.
  Network net;
  const MaterialIndex soft = net.add_material(damped(1.0, 0.0)), stiff = net.add_material(damped(100.0, 0.0));
  for (const double x : {0.0, 1.0, 2.0}) net.add_node(point({x, 0, 0}));
  net.fix(0);
  net.fix(2);
  net.add_spring(0, 1, soft);
  net.add_spring(1, 2, stiff);
  net.add_load({{1}, {5, 0, 0}});
  Simulation one = simulate(net, exactly(1), 0.05);
  CHECK(one.step().node == 2);
  Simulation two = simulate(net, exactly(2), 0.05);
  CHECK(two.step().start_node == 1);
}

TEST_CASE("after a cut the wave still reaches every part") {
  // A string cut in its middle: both halves must move as if they had never been joined.
  Network net = string_of_nodes();
  net.set_gravity({0, 0, -1});
  constexpr double force_tolerance = 1e-11;
  Simulation cut = simulate(net, recurrent(wavefront, force_tolerance), 0.05);
  Simulation plain = simulate(net, recurrent(synchronous, force_tolerance), 0.05);
  for (int i = 0; i < 10; ++i) {
    if (i == 4) {
      CHECK(cut.cut(std::vector<SpringIndex>{3}) == 1);
      CHECK(plain.cut(std::vector<SpringIndex>{3}) == 1);
    }
    cut.step();
    plain.step();
  }
  CHECK(cut.velocity(3)[2] < -0.3);
  CHECK(cut.velocity(4)[2] < -0.3);
  // Ten steps, each off by t_c tolerance / m times less than 10.
  for (NodeIndex k = 0; k < 9; ++k) CHECK((cut.position(k) - plain.position(k)).norm() < 1e-10);
}

TEST_CASE("ties start at the lowest user's number, renumbered or not") {
  for (const bool renumber : {false, true}) {
    CAPTURE(renumber);
    Network net = string_of_nodes();
    net.set_gravity({0, 0, -1});
    SimulationOptions options;
    options.time_step = 0.05;
    options.renumber = renumber;
    options.integrator = exactly(1);
    Simulation simulation(net, plugins(), options);
    CHECK(simulation.step().start_node == 1);
  }
}

TEST_CASE("renumbering changes neither the waves nor, but for rounding, the result") {
  Network net;
  Lattice lattice;
  lattice.nodes = {5, 4, 3};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(5.0, 1.0)));
  net.set_gravity({0.1, 0, -1});
  net.fix(0);
  net.fix(4);
  SimulationOptions options;
  options.time_step = 0.05;
  options.integrator = recurrent(wavefront, 1e-8);
  options.renumber = false;
  Simulation plain(net, plugins(), options);
  options.renumber = true;
  Simulation renumbered(net, plugins(), options);
  for (int i = 0; i < 5; ++i) {
    const StepReport a = plain.step();
    const StepReport b = renumbered.step();
    CHECK(a.sweeps == b.sweeps);
    CHECK(a.node == b.node);
    CHECK(a.start_node == b.start_node);
  }
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    CHECK((plain.position(k) - renumbered.position(k)).norm() < 1e-13);  // other order of sums
  }
}

TEST_CASE("parts of a network propagate in one step as each would alone") {
  // Two strings that share nothing, the second one loaded more: it starts, the other follows.
  const auto add_string = [](Network& net, double y, double load) {
    const MaterialIndex material = net.add_material(damped(10.0, 1.0));
    const auto first = static_cast<NodeIndex>(net.nodes().size());
    for (NodeIndex k = 0; k < 5; ++k) {
      net.add_node(point({static_cast<double>(k), y, 0}));
      if (k > 0) net.add_spring(first + k - 1, first + k, material);
    }
    net.fix(first);
    net.fix(first + 4);
    net.add_load({{first + 2}, {0, 0, load}});
  };
  Network both, left, right;
  add_string(both, 0, 1.0);
  add_string(both, 5, 3.0);
  add_string(left, 0, 1.0);
  add_string(right, 5, 3.0);
  constexpr double force_tolerance = 1e-11;
  Simulation together = simulate(both, recurrent(wavefront, force_tolerance), 0.1);
  Simulation one = simulate(left, recurrent(wavefront, force_tolerance), 0.1);
  Simulation two = simulate(right, recurrent(wavefront, force_tolerance), 0.1);
  for (int i = 0; i < 10; ++i) {
    const StepReport report = together.step();
    CHECK(report.outcome == Outcome::settled);
    CHECK(report.start_node >= 0);
    one.step();
    two.step();
  }
  for (NodeIndex k = 0; k < 5; ++k) {
    // Ten steps, each off by t_c tolerance / m times less than 10.
    CHECK((together.position(k) - one.position(k)).norm() < 1e-10);
    CHECK((together.position(k + 5) - two.position(k)).norm() < 1e-10);
  }
}
