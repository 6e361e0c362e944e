// Parameters that were known are recovered from the motion they gave.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "learning_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// The paper's cube in space, with velocities at random; each spring and node of its own, or all as at first.
Network cube_in_space(bool own_values) {
  Network net;
  Lattice lattice;
  lattice.nodes = {4, 4, 4};
  lattice.diagonals = Diagonals::space;
  net.add_lattice("cube", lattice, Node{}, net.add_material(damped(20.0, 1.0)));
  Dice dice(11);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    node.velocity = dice.in_box(1.0);
    const double mass = dice.decades(0.7, 1.4);
    if (own_values && k > 0) node.mass = mass;
    net.set_node(k, node);
  }
  return net;
}

struct Truth {
  std::vector<double> stiffness, damping;
};
Truth truth(std::size_t springs) {
  Dice dice(12);
  Truth result;
  for (std::size_t s = 0; s < springs; ++s) {
    result.stiffness.push_back(20.0 * dice.decades(0.6, 1.6));
    result.damping.push_back(dice.decades(0.6, 1.6));
  }
  return result;
}

// The cube whose values are known, all of them but the first mass.
struct Known {
  explicit Known(const SimulationOptions& with) : options(with) {
    Simulation simulation(real, plugins(), options);
    set(simulation);
    real_with_laws = simulation.present_network();
  }
  void set(Simulation& simulation) const {
    simulation.set_parameter(springs, ComponentKind::spring_function, "stiffness", values.stiffness);
    simulation.set_parameter(springs, ComponentKind::viscosity_function, "damping", values.damping);
  }
  [[nodiscard]] double right(const LearnedParameter& of) const {
    if (of.kind == Kind::mass) return real.nodes()[of.member].mass;
    return of.kind == Kind::spring_parameter ? values.stiffness[of.member] : values.damping[of.member];
  }
  [[nodiscard]] Observations seen_with(const LawUse& integrator, int steps) const {
    SimulationOptions own = options;
    own.integrator = integrator;
    Simulation simulation(real, plugins(), own);
    set(simulation);
    return observe(simulation, steps, from_to(0, real.nodes().size()));
  }

  SimulationOptions options;
  Network real = cube_in_space(true), guess = cube_in_space(false), real_with_laws;
  std::vector<std::uint32_t> springs = from_to(0, real.springs().size());
  Truth values = truth(springs.size());
  std::vector<Learnable> learnables{{{Kind::spring_parameter, false, "stiffness", springs}},
                                    {{Kind::viscosity_parameter, false, "damping", springs}},
                                    {{Kind::mass, false, "", from_to(1, real.nodes().size())}}};
};

}  // namespace

TEST_CASE("the cube's 252 stiffnesses, 252 dampings and 63 masses are recovered from its motion") {
  const Known known(to_learn_with(1.0, 0.05));
  REQUIRE(known.springs.size() == 252);
  const LearnedNet learned =
      learn({experiment(known.guess, known.options, known.seen_with(known.options.integrator, 20))}, plugins(),
            known.learnables);
  CAPTURE(learned.reason);
  CHECK(learned.variables == 567);
  CHECK(learned.undetermined == 0);
  double worst = 0.0;
  for (const LearnedParameter& each : learned.parameters)
    worst = std::max(worst, std::abs(each.value / known.right(each) - 1.0));
  MESSAGE("greatest relative error: ", worst);
  CHECK(worst < 1e-6);
  // Steps and systems are solved to 1e-11 of their size; the condition is about 2000.
  CHECK(learned.singular_values.front() < 1e4 * learned.singular_values.back());
}

TEST_CASE("the cube's values are recovered from the reference's motion to the stated error of the time step") {
  // Positions at the ends of steps; the reference's own accuracy is far beyond.
  const Known known(to_learn_with(0.5, 0.05));
  const LearnedNet learned =
      learn({experiment(known.guess, known.options, known.seen_with(cvode(1e-10), 20))}, plugins(), known.learnables);
  CAPTURE(learned.reason);
  CHECK(learned.undetermined == 0);
  double error = 0.0, stated = 0.0, corrected = 0.0;
  std::size_t within = 0;
  for (const LearnedParameter& each : learned.parameters) {
    const double right = known.right(each), own = each.value - right;
    // The error is of second order: half the step takes away three quarters of it.
    const double told = -each.by_time_step * 4.0 / 3.0;
    error += std::pow(own / right, 2);
    stated += std::pow(told / right, 2);
    corrected += std::pow((own - told) / right, 2);
    if (std::abs(own) <= 1.5 * std::abs(told)) ++within;
  }
  MESSAGE("relative rms: error ", std::sqrt(error / 567.0), ", stated ", std::sqrt(stated / 567.0), ", without it ",
          std::sqrt(corrected / 567.0), "; ", within, " of 567 within 1.5 of it");
  CHECK(std::sqrt(error) < 1.5 * std::sqrt(stated));
  CHECK(std::sqrt(corrected) < 0.5 * std::sqrt(error));
  CHECK(std::sqrt(error / 567.0) < 0.1);
}

TEST_CASE("with 1 % noise the cube's values lie in their intervals at the stated rate") {
  const char* const given = std::getenv("SPRINGNET_RECOVERIES");  // tests/long has more
  const int repetitions = given != nullptr ? std::atoi(given) : 5;
  const Known known(to_learn_with(0.5, 0.1));
  const Observations seen = known.seen_with(known.options.integrator, 20);
  double square = 0.0;
  for (const auto& each : seen.positions) square += (each.value - known.real.nodes()[each.node].position).squaredNorm();
  const double deviation = 0.01 * std::sqrt(square / (3.0 * static_cast<double>(seen.positions.size())));
  LearnOptions options;
  options.stages = 1;  // from the right values: what matters is where noise leads
  options.tolerance = 1e-6;
  std::size_t inside = 0, all = 0;
  double least = 1.0, most = 0.0, width = 0.0;
  for (int i = 0; i < repetitions; ++i) {
    Observations noisy = seen;
    Dice dice(100 + static_cast<std::uint64_t>(i));
    for (auto& each : noisy.positions) each.value += deviation * normal(dice);
    const LearnedNet learned = learn({experiment(known.real_with_laws, known.options, std::move(noisy))}, plugins(),
                                     known.learnables, options);
    CAPTURE(learned.reason);
    CHECK(learned.rms == doctest::Approx(deviation * std::sqrt(1.0 - 567.0 / 3840.0)).epsilon(0.05));
    std::size_t own = 0;
    for (const LearnedParameter& each : learned.parameters) {
      own += each.lower <= known.right(each) && known.right(each) <= each.upper ? 1 : 0;
      width += (each.upper - each.lower) / each.value;
    }
    const double share = static_cast<double>(own) / static_cast<double>(learned.parameters.size());
    least = std::min(least, share);
    most = std::max(most, share);
    inside += own;
    all += learned.parameters.size();
  }
  const double share = static_cast<double>(inside) / static_cast<double>(all);
  MESSAGE(repetitions, " recoveries: ", 100.0 * share, " % of the values in their intervals, ", 100.0 * least, " to ",
          100.0 * most, " % of one; mean width ", width / static_cast<double>(all), " of the value");
  CHECK(share > 0.93);
  CHECK(share < 0.97);
}
