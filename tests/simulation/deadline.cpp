// Simulation::step_within(): steps with a deadline.

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <cmath>
#include <string>

#include <springnet/error.hpp>

#include "generator.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Network hanging_lattice(std::uint32_t side) {
  Lattice lattice;
  lattice.nodes = {side, side, side};
  lattice.diagonals = Diagonals::space;
  lattice.spacing = {0.1, 0.1, 0.1};
  Network net;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(2e4, 1.0)));
  for (NodeIndex k = 0; k < side * side; ++k) net.fix(k);
  net.set_gravity({1.0, 0, -5.0});
  return net;
}

Network swinging_rods() {
  Network net = chain(12, Vector3::Zero(), {0.1, 0, 0}, damped(500.0, 0.5), 0.1);
  net.fix(0);
  for (NodeIndex k = 0; k < 10; k += 3) net.add_rigid(k, k + 1);
  net.set_gravity({0, 0, -9.81});
  return net;
}

double greatest_distance(const Simulation& a, const Simulation& b) {
  return std::sqrt((a.positions() - b.positions()).colwise().squaredNorm().maxCoeff());
}

struct Compared {
  double error, estimate, moved;  // m
  StepReport report;
};

// The step after the first ones with a deadline, and settled.
Compared compare(const Network& net, const LawUse& integrator, double time_step, double seconds, int before = 6) {
  Simulation late = simulate(net, integrator, time_step), settled = simulate(net, integrator, time_step);
  for (int i = 0; i < before; ++i) {
    late.step();
    settled.step();
  }
  const Eigen::MatrixXd start = late.positions();
  late.drop_history();
  settled.drop_history();
  const StepReport report = late.step_within(seconds);
  settled.step();
  const double moved = std::sqrt((settled.positions() - start).colwise().squaredNorm().maxCoeff());
  return {greatest_distance(late, settled), report.position_error, moved, report};
}

}  // namespace

TEST_CASE("a step with time enough is the step without a deadline, bit by bit") {
  const Network net = cube(300.0, 2.0, 2.0, 1e-3);
  for (const double rule : {synchronous, wavefront, block, coloured, newton, automatic}) {
    CAPTURE(rule);
    const double time_step = rule == synchronous || rule == wavefront ? 0.005 : 0.025;
    Simulation within = simulate(net, recurrent(rule, 0.0), time_step),
               plain = simulate(net, recurrent(rule, 0.0), time_step);
    for (int i = 0; i < 20; ++i) {
      const StepReport report = within.step_within(1e6);
      plain.step();
      REQUIRE((within.positions() == plain.positions()));
      CHECK(report.outcome == Outcome::settled);
      CHECK(std::isfinite(report.position_error));
      CHECK(std::isnan(plain.last_report().position_error));
    }
    CHECK(within.sweeps() == plain.sweeps());
  }
}

TEST_CASE("a step without time is one sweep, and says how far it is from settled") {
  struct Case {
    std::string name;
    Network net;
    double time_step;
  };
  const Case cases[] = {{"cube on a floor", cube(300.0, 2.0, 2.0, 1e-3), 0.025},
                        {"lattice", hanging_lattice(6), 0.02},
                        {"large lattice", hanging_lattice(14), 0.02},
                        {"rods", swinging_rods(), 0.02}};
  for (const Case& each : cases)
    for (const double theta : {1.0, 0.5})
      for (const double rule : {newton, block, coloured, automatic}) {
        CAPTURE(each.name);
        CAPTURE(theta);
        CAPTURE(rule);
        if (each.name == "large lattice" && rule != newton) continue;
        const LawUse integrator = recurrent(rule, 0.0, {{"theta", theta}, {"max_sweeps", 1e5}});
        const Compared found = compare(each.net, integrator, each.time_step, 0.0);
        CAPTURE(found.error);
        CAPTURE(found.estimate);
        CAPTURE(found.moved);
        CAPTURE(found.report.residual);
        CHECK(found.report.steps == 1);
        if (found.report.outcome == Outcome::settled) continue;
        CHECK(found.report.outcome == Outcome::out_of_time);
        CHECK(found.report.sweeps == 1);
        CHECK(found.report.residual > 0.0);
        REQUIRE(std::isfinite(found.estimate));
        // As documented: not below half of the error, nor beyond these multiples of it.
        CHECK(found.estimate >= 0.5 * found.error);
        CHECK(found.estimate <= (rule == newton || rule == automatic ? 30.0 : 100.0) * found.error);
      }
}

TEST_CASE("a step without time keeps nodes out of obstacles, and rigid lengths") {
  Simulation falling = simulate(cube(300.0, 2.0, 2.0, 0.02), recurrent(newton, 0.0), 0.025);
  for (int i = 0; i < 40; ++i) {
    falling.step_within(0.0);
    CHECK(falling.positions().row(2).minCoeff() >= -1e-9);
  }
  CHECK(falling.nodes_touching(0) > 0);
  CHECK(falling.time() == doctest::Approx(1.0));
  const Network rods = swinging_rods();
  Simulation swinging = simulate(rods, recurrent(newton, 0.0), 0.02);
  for (int i = 0; i < 40; ++i) {
    swinging.step_within(0.0);
    for (NodeIndex k = 0; k < 10; k += 3)
      CHECK((swinging.position(k + 1) - swinging.position(k)).norm() == doctest::Approx(0.1).epsilon(1e-7));
  }
  CHECK(swinging.statistics().at("out_of_time_steps") > 0.0);
}

TEST_CASE("a deadline ends the solution of a linear system") {
  const Network net = hanging_lattice(14);
  Simulation simulation = simulate(net, recurrent(newton, 0.0), 0.2);
  simulation.step_within(0.0);
  CHECK(simulation.statistics().at("krylov_iterations") <= 16.0);  // of two solutions
  CHECK(simulation.positions().allFinite());
  CHECK(simulation.last_report().outcome == Outcome::out_of_time);
  Simulation whole = simulate(net, recurrent(newton, 0.0), 0.2);
  whole.step();
  CHECK(whole.statistics().at("krylov_iterations") > 32.0);
}

TEST_CASE("a step without time has the same bits for every number of threads") {
  const Network net = hanging_lattice(16);
  const auto run = [&net](unsigned threads) {
    SimulationOptions options;
    options.integrator = recurrent(newton, 0.0);
    options.time_step = 0.02;
    options.threads = threads;
    Simulation simulation(net, plugins(), options);
    for (int i = 0; i < 3; ++i) simulation.step_within(0.0);
    return Eigen::MatrixXd(simulation.positions());
  };
  CHECK((run(1) == run(2)));
}

TEST_CASE("a time for a step is a number of seconds") {
  Simulation simulation = simulate(swinging_rods(), recurrent(newton, 0.0), 0.02);
  for (const double wrong : {-1.0, std::nan("")}) CHECK_THROWS_AS(simulation.step_within(wrong), Error);
  CHECK(simulation.step_within(std::numeric_limits<double>::infinity()).outcome == Outcome::settled);
  Simulation reference = simulate(swinging_rods(), cvode(1e-6), 0.02);
  CHECK(reference.step_within(0.0).outcome == Outcome::settled);
}

TEST_CASE("after a deadline a sweep of Newton's method does not search for a better step") {
  // A spring that stiffens, hit so hard that the first sweeps are far off: without a deadline they take up to 22
  // evaluations until a step is good. One for the start, one a sweep, one where the outputs stay, and that at the end.
  for (const double exponent : {50.0, 300.0, 1000.0}) {
    for (const double stiffness : {100.0, 1e5}) {
      for (const double speed : {-150.0, 40.0, 70.0, 200.0, 500.0}) {
        CAPTURE(exponent);
        CAPTURE(stiffness);
        CAPTURE(speed);
        const Material tissue{LawUse{"exponential", {{"stiffness", stiffness}, {"exponent", exponent}}}, std::nullopt};
        Simulation simulation = simulate(oscillator(tissue, 1.0, 0.0, speed), recurrent(newton, 1e-9), 0.01);
        const StepReport report = simulation.step_within(0.0);
        CHECK(report.outcome == Outcome::out_of_time);
        CHECK(report.sweeps <= 2);
        CHECK(simulation.statistics().at("evaluations") <= 5);
        CHECK(std::isfinite(report.residual));
      }
    }
  }
}
