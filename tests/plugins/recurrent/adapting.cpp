// Steps that do not settle as they are: continuation in the time constant, or subdivision; and the rule that
// "automatic" selects.
#include <cmath>
#include <string>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "facts.hpp"
#include "random_nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

// A stiffening spring that was stretched to where its stiffness is e^6 times that at rest.
Network stretched() {
  return oscillator({LawUse{"exponential", {{"stiffness", 20.0}, {"exponent", 8.0}}}, std::nullopt}, 1.0, 0.75);
}

// One free node on one spring; synchronous sweeps settle while t_c^2 k / m is below 1.
Simulation adapting_spring(double stiffness, double policy, ParameterValues more = {}) {
  more["unsettled"] = policy;
  return simulate(oscillator(damped(stiffness, 0.0), 1.0, 0.1), recurrent(synchronous, 1e-9, std::move(more)), 1.0);
}

}  // namespace

TEST_CASE("continuation ends at the state that Newton's method finds for the undivided step") {
  constexpr double t_c = 0.5, force_tolerance = 1e-9;
  // So few sweeps that the whole way is too long for them.
  const ParameterValues few{{"max_sweeps", 8}, {"unsettled", on_unsettled_adapt}};
  Simulation undivided = simulate(stretched(), recurrent(newton, force_tolerance), t_c);
  Simulation in_stages = simulate(stretched(), recurrent(newton, force_tolerance, few), t_c);
  const StepReport whole = undivided.step();
  const StepReport report = in_stages.step();
  CHECK(whole.sweeps > 8);
  CHECK(whole.stages == 0);
  CHECK(report.outcome == Outcome::settled);
  CHECK(report.stages > 0);
  CHECK(report.substeps == 0);
  CHECK(report.sweeps > report.stages);
  CHECK(in_stages.time() == t_c);
  CHECK(in_stages.statistics().at("stages") == static_cast<double>(report.stages));
  // Twice the tolerance over m / t_c^2, for both.
  const double tolerance = 4 * force_tolerance * t_c * t_c;
  CHECK((in_stages.position(1) - undivided.position(1)).norm() < tolerance);
  CHECK((in_stages.velocity(1) - undivided.velocity(1)).norm() < tolerance / t_c);
}

TEST_CASE("subdivision takes smaller steps, reports their number and keeps to the grid of times") {
  // t_c^2 k / m = 6: a half is above 1 as well, a quarter is not.
  Simulation divided = adapting_spring(6.0, on_unsettled_adapt);
  SimulationOptions options;
  options.time_step = 0.25;
  options.threads = 1;
  options.integrator = recurrent(synchronous, 1e-9);
  Simulation small(oscillator(damped(6.0, 0.0), 1.0, 0.1), plugins(), options);
  for (int i = 1; i <= 3; ++i) {
    const StepReport report = divided.step();
    for (int j = 0; j < 4; ++j) small.step();
    CHECK(report.outcome == Outcome::settled);
    CHECK(report.steps == 1);
    CHECK(report.substeps == 4);
    CHECK(divided.steps() == static_cast<std::uint64_t>(i));
    CHECK(divided.time() == i);
    CHECK(divided.statistics().at("substeps") == 4 * i);
    CHECK(divided.position(1) == small.position(1));  // the same steps, bit for bit
    CHECK(divided.velocity(1) == small.velocity(1));
  }
  // Back to whole steps as soon as they settle.
  Simulation easing = adapting_spring(6.0, on_unsettled_adapt);
  CHECK(easing.step().substeps == 4);
  easing.cut({0});
  CHECK(easing.step().substeps == 0);
}

TEST_CASE("a step that no subdivision settles ends in an error that advises rules and less stiffness") {
  // t_c^2 k / m = 1e10: a step of 2^-12 is far above 1.
  Simulation simulation = adapting_spring(1e10, on_unsettled_adapt);
  std::string why;
  try {
    simulation.step();
  } catch (const Error& error) {
    why = error.what();
  }
  CHECK(has_all(why, {"\"newton\"", "\"automatic\"", "stiffness"}));
  CHECK_FALSE(has(why, "smaller time_step"));
  CHECK(simulation.time() == 0.0);
}

TEST_CASE("automatic notes the rule that it selects and the critical time constant") {
  // sqrt(m / k) = 0.5 s is the critical time constant of an oscillator without damping.
  const auto note_of = [](double t_c, double damping) {
    Simulation simulation = simulate(oscillator(damped(4.0, damping), 1.0, 0.1), {"recurrent", {}}, t_c);
    simulation.step();
    REQUIRE(simulation.notes().size() == 1);
    simulation.step();
    CHECK(simulation.notes().size() == 1);  // once
    return simulation.notes()[0];
  };
  const std::string short_step = note_of(0.1, 0.0), long_step = note_of(5.0, 0.0), viscous = note_of(0.1, 2.0);
  CHECK(has_all(short_step, {"rule synchronous", " 0.2 times", " 0.5 s"}));
  CHECK(has_all(long_step, {"rule newton", " 10 times", " 0.5 s"}));
  // Synchronous sweeps up to three quarters of it.
  CHECK(has(note_of(0.36, 0.0), "rule synchronous: "));
  CHECK(has(note_of(0.39, 0.0), "rule synchronous, accelerated: "));
  // Accelerated ones up to a fifth more than all of it.
  CHECK(has(note_of(0.58, 0.0), "rule synchronous, accelerated: "));
  CHECK(has(note_of(0.62, 0.0), "rule newton"));
  // t_c^2 k / m + t_c d / m = 1 at (sqrt(5) - 1) / 4 = 0.309 s.
  CHECK(has(viscous, " 0.31 s"));
}

TEST_CASE("where nothing limits the time step, the note has no numbers") {
  Network net;
  net.add_node(point(Vector3::Zero()));
  net.set_gravity({0, 0, -9.81});
  Simulation simulation = simulate(net, {"recurrent", {}}, 0.1);
  simulation.step();
  const std::string note = simulation.notes().at(0);
  CHECK(has(note, "synchronous"));
  CHECK(note.find_first_of("0123456789") == std::string::npos);
}

TEST_CASE("a step that the selected rule does not settle is solved with Newton's method") {
  // At rest the spring is soft; node 1 moves away from the wall and stiffens it a thousandfold.
  Network net =
      oscillator({LawUse{"exponential", {{"stiffness", 1.0}, {"exponent", 10.0}}}, std::nullopt}, 1.0, 0.0, 4.0);
  Simulation simulation = simulate(net, {"recurrent", {}}, 0.1);
  for (int i = 0; i < 20; ++i) CHECK(simulation.step().outcome == Outcome::settled);
  CHECK(has(simulation.notes().at(0), "synchronous"));
  CHECK(has_all(simulation.notes().at(1), {"synchronous", "newton"}));
  CHECK(simulation.statistics().at("escalated_steps") >= 1);
  // The same steps as with Newton's method throughout.
  Simulation newtons = simulate(net, recurrent(newton, 0), 0.1);
  for (int i = 0; i < 20; ++i) newtons.step();
  // Each step leaves up to twice the tolerance of 1e-6 m v^2 / l = 1.6e-5 N over m / t_c^2, in both, and carries it on
  // for 20 steps through a bounce that stretches differences.
  CHECK((simulation.position(1) - newtons.position(1)).norm() < 1e-3);
}

TEST_CASE("irregular nets over six decades settle under the default rule, with a residual of twice the threshold") {
  // A sample; each of the few that do not settle reports it.
  int settled = 0;
  constexpr int count = 40;
  for (unsigned seed = 1; seed <= count; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const Network net = random_net(random, {2 + random.below(100), 6.0, false, seed % 2 == 0});
    constexpr double force_tolerance = 1e-3;
    Simulation simulation = simulate(net, recurrent(automatic, force_tolerance), random.decades(0.02, 1.0));
    try {
      for (int i = 0; i < 4; ++i) CHECK(simulation.step().residual <= 2 * force_tolerance);
      ++settled;
    } catch (const Error& error) {
      CHECK(simulation.last_report().outcome != Outcome::settled);
    }
  }
  CHECK(settled >= 0.95 * count);
}
