// Anderson acceleration: the fixed point of Newton's method in fewer sweeps, beyond the limit of plain sweeps too.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "random_nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

constexpr std::array accelerated_rules{synchronous, wavefront, block, coloured};

LawUse accelerated(double update, double depth, double force_tolerance, ParameterValues more = {}) {
  more["acceleration"] = depth;
  return recurrent(update, force_tolerance, std::move(more));
}

double greatest_distance(const Simulation& a, const Simulation& b) {
  double greatest = 0.0;
  for (NodeIndex k = 0; k < a.node_count(); ++k) greatest = std::max(greatest, (a.position(k) - b.position(k)).norm());
  return greatest;
}

// The paper's cube above a floor.
Network paper_cube(Friction::Kind friction) {
  Network net;
  Lattice lattice;
  lattice.nodes = {4, 4, 4};
  lattice.origin = {0, 0, 0.081};
  lattice.diagonals = Diagonals::space;
  net.add_lattice("cube", lattice, Node{}, net.add_material(damped(3.0, 2.0)));
  net.set_gravity({0, 0, -0.2});
  Plane floor{"floor", Vector3::Zero(), Vector3::UnitZ()};
  floor.friction = {friction, 0.3};
  net.add_plane(floor);
  return net;
}

// Four nodes in a line between two walls, all of it linear, with t_c^2 k / m = `ratio` for t_c = 0.1 s.
Network line(double ratio) {
  Network net = chain(6, Vector3::Zero(), {1, 0, 0}, damped(100.0 * ratio, 0.0));
  net.fix(0);
  net.fix(5);
  for (NodeIndex k = 1; k < 5; ++k) {
    Node node = net.nodes()[k];
    node.velocity = {k == 2 ? 1.0 : 0.3 * k * k, 0, 0};
    net.set_node(k, node);
  }
  return net;
}

}  // namespace

TEST_CASE("with a linear network of n unknowns accelerated sweeps settle after n + 1, like GMRES") {
  constexpr double t_c = 0.1, force_tolerance = 1e-6;
  for (const double ratio : {0.2, 1.0, 10.0, 100.0}) {
    for (const double update : {synchronous, block, coloured}) {
      CAPTURE(ratio);
      CAPTURE(update);
      const Network net = line(ratio);
      Simulation reference = simulate(net, recurrent(newton, force_tolerance), t_c);
      Simulation simulation = simulate(net, accelerated(update, 20, force_tolerance), t_c);
      const StepReport report = simulation.step();
      reference.step();
      CHECK(report.outcome == Outcome::settled);
      CHECK(report.residual <= 2 * force_tolerance);
      // Four unknowns: five sweeps. Before them the first one, which starts from p and v instead of p + t_c v and v,
      // and up to two that went too far; after them two, whose forces show that nothing changes any more.
      CHECK(report.sweeps <= 5 + 5);
      CHECK(greatest_distance(simulation, reference) < 4 * force_tolerance * t_c * t_c * 2);
    }
  }
  // With fewer differences than unknowns it takes longer.
  Simulation shallow = simulate(line(10.0), accelerated(synchronous, 1, force_tolerance), t_c);
  CHECK(shallow.step().sweeps > 2 * 8);
}

TEST_CASE("accelerated rules reach the fixed point that Newton's method finds, on irregular nets with all laws") {
  constexpr double force_tolerance = 1e-8;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    for (const double theta : {1.0, 0.5}) {
      Random random(seed);
      const Network net = random_net(random, {5 + random.below(40), 1.0, true});
      double lightest = 1.0;
      for (const Node& node : net.nodes()) lightest = std::min(lightest, node.mass);
      const double update = accelerated_rules[seed % 4], depth = 2.0 + seed % 3 * 4.0;
      // Up to two and a half times the limit of synchronous sweeps.
      for (const double t_c : {0.01, 0.05}) {
        CAPTURE(seed);
        CAPTURE(theta);
        CAPTURE(update);
        CAPTURE(t_c);
        Simulation reference = simulate(net, recurrent(newton, force_tolerance, {{"theta", theta}}), t_c);
        Simulation simulation = simulate(net, accelerated(update, depth, force_tolerance, {{"theta", theta}}), t_c);
        for (int step = 0; step < 6; ++step) {
          if (step == 3) {
            simulation.cut({0, 2});
            reference.cut({0, 2});
          }
          const StepReport report = simulation.step();
          reference.step();
          CHECK(report.outcome == Outcome::settled);
          CHECK(report.residual <= 2 * force_tolerance);
        }
        // As in rules.cpp; theta 1/2 does not damp what a step leaves.
        const double step_error = 4 * force_tolerance * t_c * t_c / lightest;
        CHECK(greatest_distance(simulation, reference) <
              2 * 21 * step_error * std::sqrt(static_cast<double>(net.nodes().size())) + 1e-13);
      }
    }
  }
}

TEST_CASE("a step that accelerated sweeps do not settle is made by plain ones") {
  // Nets, far above their limits, in which combined sweeps of these rules end in a cycle (found by a search).
  struct Stubborn {
    unsigned seed;
    double update, depth, theta;
  };
  for (const Stubborn& net : {Stubborn{27, coloured, 3, 1.0}, Stubborn{98, block, 4, 1.0},
                              Stubborn{55, coloured, 1, 0.5}, Stubborn{86, block, 2, 1.0}}) {
    CAPTURE(net.seed);
    constexpr double t_c = 1.0, force_tolerance = 1e-10;
    Random random(net.seed);
    const Network network = random_net(random, {5 + random.below(40), 1.0, true});
    Simulation plain = simulate(network, recurrent(net.update, force_tolerance, {{"theta", net.theta}}), t_c);
    Simulation simulation =
        simulate(network, accelerated(net.update, net.depth, force_tolerance, {{"theta", net.theta}}), t_c);
    for (int step = 0; step < 6; ++step) {
      if (step == 3) {
        plain.cut({0, 2});
        simulation.cut({0, 2});
      }
      plain.step();
      const StepReport report = simulation.step();
      CHECK(report.outcome == Outcome::settled);
      CHECK(report.residual <= 2 * force_tolerance);
      CHECK(report.sweeps <= 2 * 1000);  // max_sweeps, twice
    }
  }
}

TEST_CASE("accelerated sweeps settle where plain ones diverge, in contact too, and where they do not in fewer") {
  constexpr double t_c = 0.2, force_tolerance = 1e-7;
  for (const double t_c_over_limit : {1.0, 2.0}) {
    for (const double update : {synchronous, wavefront}) {
      for (const Friction::Kind kind : {Friction::Kind::held, Friction::Kind::coulomb}) {
        CAPTURE(t_c_over_limit);
        CAPTURE(update);
        const Network net = paper_cube(kind);
        const double h = t_c * t_c_over_limit;
        Simulation plain = simulate(net, recurrent(update, force_tolerance), h);
        CHECK_THROWS_AS(
            [&] {
              for (int step = 0; step < 20; ++step) plain.step();
            }(),
            Error);
        Simulation reference = simulate(net, recurrent(newton, force_tolerance), h);
        Simulation simulation = simulate(net, accelerated(update, 5, force_tolerance), h);
        for (int step = 0; step < 20; ++step) {
          const StepReport report = simulation.step();
          reference.step();
          CHECK(report.outcome == Outcome::settled);
          CHECK(report.residual <= 2 * force_tolerance);
          for (NodeIndex k = 0; k < 64; ++k) CHECK(simulation.touching(k) == reference.touching(k));
        }
        CHECK(greatest_distance(simulation, reference) < 1e-6);
      }
    }
  }
  // Within the limit of all rules, also in the steps in which the cube lands.
  for (const double update : accelerated_rules) {
    for (const double depth : {2.0, 5.0, 10.0}) {
      CAPTURE(update);
      CAPTURE(depth);
      const Network net = paper_cube(Friction::Kind::held);
      Simulation plain = simulate(net, recurrent(update, force_tolerance), 0.05);
      Simulation simulation = simulate(net, accelerated(update, depth, force_tolerance), 0.05);
      std::uint64_t most_sweeps = 0;
      for (int step = 0; step < 60; ++step) {
        plain.step();
        most_sweeps = std::max(most_sweeps, simulation.step().sweeps);
      }
      CHECK(simulation.sweeps() < plain.sweeps());
      if (update == synchronous) CHECK(2 * simulation.sweeps() < plain.sweeps());
      CHECK(most_sweeps < 40);
      CHECK(greatest_distance(simulation, plain) < 1e-7);
    }
  }
}

TEST_CASE("accelerated sweeps give the same bits for every number of threads, and nothing lives on from step to step") {
  Network net;
  Lattice lattice;
  lattice.nodes = {20, 20, 20};
  lattice.diagonals = Diagonals::space;
  net.add_lattice("jelly", lattice, Node{}, net.add_material(damped(300.0, 2.0)));
  for (NodeIndex k = 0; k < 400; ++k) net.fix(k);
  net.set_gravity({0.5, 0, -1});
  for (const double update : {synchronous, coloured}) {
    CAPTURE(update);
    Eigen::MatrixXd alone;
    for (const unsigned threads : {1u, 2u, 3u}) {
      SimulationOptions options;
      options.time_step = 0.04;
      options.threads = threads;
      options.integrator = accelerated(update, 4, 1e-6);
      Simulation simulation(net, plugins(), options);
      for (int step = 0; step < 2; ++step) simulation.step();
      if (threads == 1) alone = simulation.positions();
      CHECK(alone == simulation.positions());
    }
  }
  // A step from a state is the same whatever led to it.
  for (const double update : accelerated_rules) {
    CAPTURE(update);
    Network small = cube(30.0, 2.0, 0.2, 1.0);
    Node kicked = small.nodes()[7];
    kicked.velocity = {0.3, -0.2, 0.5};
    small.set_node(7, kicked);
    const LawUse integrator = accelerated(update, 4, 1e-7);
    Simulation one = simulate(small, integrator, 0.1);
    one.step();
    for (NodeIndex k = 0; k < 64; ++k) {
      Node node = small.nodes()[k];
      node.position = one.position(k);
      node.velocity = one.velocity(k);
      small.set_node(k, node);
    }
    Simulation two = simulate(small, integrator, 0.1);
    one.step();
    two.step();
    for (NodeIndex k = 0; k < 64; ++k) CHECK(one.position(k) == two.position(k));
  }
}

TEST_CASE("acceleration is refused where it means nothing") {
  const Network net = line(1.0);
  for (const LawUse& integrator :
       {accelerated(synchronous, 5, 0, {{"sweeps", 1}}), accelerated(wavefront, 1, 0, {{"sweeps", 7}}),
        accelerated(automatic, 1, 0, {{"sweeps", 7}}), accelerated(newton, 5, 0), accelerated(block, 21, 0),
        accelerated(block, -1, 0), accelerated(block, 1.5, 0)}) {
    CHECK_THROWS_WITH_AS(simulate(net, integrator, 0.1), doctest::Contains("acceleration"), Error);
  }
  // automatic uses it where it does not choose Newton's method.
  Simulation simulation = simulate(net, accelerated(automatic, 5, 1e-6), 0.1);
  CHECK(simulation.step().outcome == Outcome::settled);
}
