// Update rules: the same fixed point, their range of convergence, and the sweeps that they need.
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

double greatest_distance(const Simulation& a, const Simulation& b) {
  double greatest = 0.0;
  for (NodeIndex k = 0; k < a.node_count(); ++k) greatest = std::max(greatest, (a.position(k) - b.position(k)).norm());
  return greatest;
}

// The paper's cube with t_c^2 k / m and t_c d / m, falling on its floor.
Simulation falling_cube(double stiffness_number, double damping_number, double update) {
  constexpr double t_c = 0.05;
  return simulate(cube(stiffness_number / (t_c * t_c), damping_number / t_c, 1.0, 0.081), recurrent(update, 1e-6), t_c);
}

}  // namespace

TEST_CASE("all rules reach the fixed point that Newton's method finds, on irregular nets with all laws") {
  constexpr double t_c = 0.01, force_tolerance = 1e-8;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const Network net = random_net(random, {5 + random.below(40), 1.0, true});
    double lightest = 1.0;
    for (const Node& node : net.nodes()) lightest = std::min(lightest, node.mass);
    Simulation reference = simulate(net, recurrent(newton, force_tolerance), t_c);
    for (const double update : {synchronous, wavefront, block, coloured}) {
      CAPTURE(update);
      Simulation simulation = simulate(net, recurrent(update, force_tolerance), t_c);
      Simulation other = simulate(net, recurrent(newton, force_tolerance), t_c);
      for (int step = 0; step < 5; ++step) {
        const StepReport report = simulation.step();
        other.step();
        CHECK(report.outcome == Outcome::settled);
        CHECK(report.residual <= 2 * force_tolerance);
      }
      // m / t_c^2 is the smallest eigenvalue of what keeps nodes together in a step, and twice the residual of each
      // rule may be left in every step; later steps carry on displacement and velocity, one t_c after another: 1 + 2 +
      // … + 5. Forces on many nodes may add up in one of them: the root of their number.
      const double step_error = 4 * force_tolerance * t_c * t_c / lightest;
      CHECK(greatest_distance(simulation, other) <
            15 * step_error * std::sqrt(static_cast<double>(net.nodes().size())) + 1e-13);
    }
  }
}

TEST_CASE("block settles where the wavefront diverges, in the sweeps of a prototype") {
  // k 60, d 20: 36 sweeps a step in the prototype.
  for (const double update : {block, coloured}) {
    CAPTURE(update);
    Simulation simulation = falling_cube(0.15, 1.0, update);
    for (int i = 0; i < 40; ++i) {
      const StepReport report = simulation.step();
      CHECK(report.outcome == Outcome::settled);
      CHECK(report.residual <= 2e-6);
    }
    const double sweeps = static_cast<double>(simulation.sweeps()) / 40;
    CHECK(sweeps > 10);
    CHECK(sweeps < 45);
  }
  Simulation simulation = falling_cube(0.15, 1.0, wavefront);
  CHECK_THROWS_AS(simulation.step(), Error);
}

TEST_CASE("Newton's method settles in a handful of sweeps whatever the stiffness") {
  for (const double stiffness : {0.01, 1.0, 40.0, 1e4}) {
    for (const double damping : {0.01, 20.0, 1e3}) {
      CAPTURE(stiffness);
      CAPTURE(damping);
      Simulation simulation = falling_cube(stiffness, damping, newton);
      for (int i = 0; i < 30; ++i) {
        const StepReport report = simulation.step();
        CHECK(report.outcome == Outcome::settled);
        CHECK(report.residual <= 2e-6);
      }
      // Where a node touches depends on the force on it, which the linear system of a sweep does not know: the steps in
      // which the cube lands take some tens of sweeps where springs are stiffest.
      CHECK(simulation.sweeps() < 30 * (stiffness > 100.0 ? 16 : 8));
    }
  }
}

TEST_CASE("Newton's method on large nets, solved iteratively, and on long chains, factorised") {
  // A lattice of 1000 nodes against coloured sweeps; a chain of 200 nodes with t_c^2 k / m = 2500 against a direct
  // solution: under gravity, all linear, its fall from rest is the same for all nodes but those near the wall.
  Network lattice_net;
  Lattice lattice;
  lattice.nodes = {10, 10, 10};
  lattice.diagonals = Diagonals::space;
  lattice_net.add_lattice("jelly", lattice, Node{}, lattice_net.add_material(damped(300.0, 20.0)));
  for (NodeIndex k = 0; k < 100; ++k) lattice_net.fix(k);
  lattice_net.set_gravity({0.5, 0, -1});
  constexpr double force_tolerance = 1e-8, t_c = 0.05;
  Simulation a = simulate(lattice_net, recurrent(newton, force_tolerance), t_c);
  Simulation b = simulate(lattice_net, recurrent(coloured, force_tolerance, {{"max_sweeps", 5000}}), t_c);
  for (int i = 0; i < 2; ++i) {
    CHECK(a.step().residual <= 2 * force_tolerance);
    CHECK(b.step().residual <= 2 * force_tolerance);
  }
  // Twice the tolerance on each of 1000 nodes in both, over m / t_c^2, and once more in the second step.
  CHECK(greatest_distance(a, b) < 3 * 4 * force_tolerance * t_c * t_c * std::sqrt(1000.0));

  Network rope = chain(200, Vector3::Zero(), {1, 0, 0}, damped(1e6, 1.0));
  rope.fix(0);
  rope.add_load({{199}, {5.0, 0, 0}});
  Simulation pulled = simulate(rope, recurrent(newton, 1e-7), t_c);
  const StepReport report = pulled.step();
  CHECK(report.outcome == Outcome::settled);
  CHECK(report.sweeps < 8);
  // Backward Euler of a uniform rod: (1 + 2 (c - 1)) decays by exp(-s) a node, cosh s = 1 + m / (2 (t_c^2 k + t_c d)).
  const double coupling = t_c * t_c * 1e6 + t_c * 1.0;
  const double s = std::acosh(1.0 + 1.0 / (2.0 * coupling));
  // x_n = A sinh(n s) with the end's equation x_N + coupling (x_N - x_{N-1}) = t_c^2 F.
  const double amplitude =
      t_c * t_c * 5.0 / (std::sinh(199 * s) + coupling * (std::sinh(199 * s) - std::sinh(198 * s)));
  for (const NodeIndex k : {1u, 50u, 150u, 199u}) {
    // The residual, 2e-7 N at each of 200 nodes, over the smallest eigenvalue m / t_c^2; rounding of positions of 200
    // m.
    CHECK(std::abs(pulled.position(k)[0] - k - amplitude * std::sinh(k * s)) < 1e-8);
  }
}

TEST_CASE("a truss snaps through in one step, to the residual of the equation of motion") {
  // Two bars of stiffness k from (+-1, 0, 0) to an apex at height 0.3; the load is far beyond what the bars hold, and
  // the step so long that inertia is a hundredth of their stiffness: the apex has to go through.
  constexpr double stiffness = 1000.0, height = 0.3, load = 40.0, t_c = 0.2;
  Network net;
  for (const double x : {-1.0, 1.0}) {
    Node support = point({x, 0, 0});
    support.fixed = true;
    net.add_node(support);
  }
  net.add_node(point({0, 0, height}, 0.5));
  const MaterialIndex bar = net.add_material(damped(stiffness, 0.0));
  net.add_spring(0, 2, bar);
  net.add_spring(1, 2, bar);
  net.add_load({{2}, {0, 0, -load}});
  const double rest = std::sqrt(1.0 + height * height);
  const auto force = [&](double z) {
    const double length = std::sqrt(1.0 + z * z);
    return -2.0 * stiffness * (length - rest) * z / length - load;
  };
  for (const double update : {newton, block, automatic}) {
    CAPTURE(update);
    Simulation simulation = simulate(net, recurrent(update, 1e-9), t_c);
    double z = height, velocity = 0.0;
    for (int i = 0; i < 5; ++i) {
      const StepReport report = simulation.step();
      CHECK(report.outcome == Outcome::settled);
      CHECK(report.sweeps < 60);
      const double next = simulation.position(2)[2];
      // The equation of motion of the step, written out here: its residual is at most twice the tolerance, and
      // rounding.
      CHECK(std::abs(0.5 * ((next - z) / t_c - velocity) / t_c - force(next)) < 2e-9 + 1e-10);
      velocity = (next - z) / t_c;
      z = next;
    }
    CHECK(z < -height);  // through, and hanging
  }
}

TEST_CASE("a law that softens: beyond its greatest tension only inertia holds the node") {
  // T = 100 x - 100 x^3 + 30 x^5 rises to 41 N at x = 0.65, falls to 30 N at 1.26, and rises again; the load is 45 N.
  const LawUse softening{"nonlinear", {{"stiffness", 100.0}, {"cubic", -100.0}, {"quintic", 30.0}}};
  Network net = oscillator({softening, std::nullopt}, 1.0, 0.3);
  net.add_load({{1}, {45.0, 0, 0}});
  constexpr double t_c = 0.1;
  const auto force = [](double x) { return 45.0 - 100.0 * x + 100.0 * x * x * x - 30.0 * std::pow(x, 5); };
  for (const double update : {newton, block, automatic}) {
    CAPTURE(update);
    Simulation simulation = simulate(net, recurrent(update, 1e-9), t_c);
    double x = 0.3, velocity = 0.0;
    double furthest = 0.0;
    for (int i = 0; i < 10; ++i) {
      CHECK(simulation.step().outcome == Outcome::settled);
      const double next = simulation.position(1)[0] - 1.0;
      CHECK(std::abs(((next - x) / t_c - velocity) / t_c - force(next)) < 2e-9 + 1e-10);  // and rounding
      velocity = (next - x) / t_c;
      x = next;
      furthest = std::max(furthest, x);
    }
    CHECK(furthest > 1.26);
  }
}

TEST_CASE("coloured sweeps have the same bits for every number of threads") {
  Network net;
  Lattice lattice;
  lattice.nodes = {23, 23, 23};  // 12167 nodes: a unit has 8192 at most
  lattice.diagonals = Diagonals::space;
  net.add_lattice("jelly", lattice, Node{}, net.add_material(damped(40.0, 2.0)));
  net.fix(0);
  net.set_gravity({0, 0, -1});
  std::vector<Simulation> simulations;
  for (const unsigned threads : {1u, 2u, 3u}) {
    SimulationOptions options;
    options.time_step = 0.05;
    options.threads = threads;
    options.integrator = recurrent(coloured, 0, {{"sweeps", 4}});
    simulations.emplace_back(net, plugins(), options);
  }
  const StepReport one = simulations[0].step();
  for (std::size_t j = 1; j < simulations.size(); ++j) {
    const StepReport many = simulations[j].step();
    CHECK(many.force_difference == one.force_difference);
    CHECK(many.residual == one.residual);
    CHECK(many.node == one.node);
    CHECK(simulations[j].positions() == simulations[0].positions());
    CHECK(simulations[j].velocities() == simulations[0].velocities());
  }
}
