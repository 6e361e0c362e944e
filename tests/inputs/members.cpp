// Which springs and elements read which signal.
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include "laws.hpp"
#include "layers/input_sets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

constexpr std::uint32_t side = 7;

// A lattice of motors; `tension` of each spring.
Network lattice(const LawUse& law) {
  Network net;
  Lattice box;
  box.nodes = {side, side, side};
  box.diagonals = Diagonals::space;
  net.add_lattice("box", box, point(Vector3::Zero()), net.add_material({law, LawUse{"linear", {{"damping", 0.4}}}}));
  return net;
}

}  // namespace

TEST_CASE("signals of many springs act as so many parameters, bit by bit, for all threads and instruction sets") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> tension(-1.0, 1.0);
  Network signals = lattice({"motor", {}}), parameters = lattice({"motor", {}});
  // Some springs have a signal of their own, some share one, some have none.
  std::vector<SpringIndex> shared;
  for (SpringIndex s = 0; s < signals.springs().size(); ++s) {
    const int kind = static_cast<int>(random() % 4);
    const double value = kind < 2 ? tension(random) : kind == 2 ? 0.25 : 0.0;
    if (kind == 2) shared.push_back(s);
    if (kind < 2) {
      Input own;
      own.input = "tension";
      own.springs = {s};
      own.signal = constant(value);
      signals.add_input(own);
    }
    Material material{LawUse{"motor", {{"extra", value}}}, LawUse{"linear", {{"damping", 0.4}}}};
    parameters.set_spring_material(s, parameters.add_material(material));
  }
  Input common;
  common.input = "tension";
  common.springs = shared;
  common.signal = constant(0.25);
  signals.add_input(common);
  for (const LawUse& method : {recurrent(newton, 1e-9), recurrent(wavefront, 1e-9), single_sweep(), cvode(1e-6)}) {
    CAPTURE(method.id);
    const auto end = [&](const Network& net, unsigned threads, InstructionSet set) {
      Simulation simulation = simulate_with_inputs(net, method, 0.02, threads, set);
      simulation.advance_to(0.2);
      return Eigen::MatrixXd(simulation.positions()(Eigen::all, simulation.columns()));
    };
    const Eigen::MatrixXd one = end(signals, 1, InstructionSet::generic);
    CHECK(one == end(signals, 3, InstructionSet::best));
    // The order of sums over springs follows materials, so the bits of two networks may differ in the last place.
    CHECK((one - end(parameters, 1, InstructionSet::generic)).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("of several signals for the same input the last one counts") {
  Network net = oscillator({LawUse{"motor", {}}, std::nullopt}, 1.0, 0.5);
  for (const double value : {3.0, 4.0, 5.0}) {
    Input input;
    input.input = "tension";
    input.springs = {0, 0};
    input.signal = constant(value);
    net.add_input(input);
  }
  const Simulation simulation = simulate_with_inputs(net, recurrent(newton, 1e-9), 0.1);
  CHECK(simulation.tension(0) == 5.0);
}

TEST_CASE("sets of signals differ in nothing that no law reads") {
  Network net;
  for (int k = 0; k < 4; ++k) net.add_node(point({double(k), 0, 0}));
  const MaterialIndex motor = net.add_material({LawUse{"motor", {}}, std::nullopt});
  const MaterialIndex linear = net.add_material({LawUse{"linear", {{"stiffness", 1.0}}}, std::nullopt});
  net.add_spring(0, 1, motor);
  net.add_spring(1, 2, motor);
  net.add_spring(2, 3, linear);
  const auto add = [&](std::vector<SpringIndex> springs) {
    Input input;
    input.input = "tension";
    input.springs = std::move(springs);
    input.signal = constant(1.0);
    net.add_input(input);
  };
  add({0});
  add({0, 1, 2});
  const layers::InputSets sets(net, *plugins_with_inputs());
  CHECK(sets.of_springs()[0] == sets.of_springs()[1]);  // the first signal of spring 0 is overridden
  CHECK(sets.signal(sets.of_springs()[0], "tension") == 1);
  CHECK(sets.of_springs()[2] == 0);  // reads nothing
}

TEST_CASE("a signal that changes too fast for numbers is refused") {
  Network net = oscillator({LawUse{"motor", {}}, std::nullopt}, 1.0, 0.5);
  Input input;
  input.input = "tension";
  input.springs = {0};
  for (const auto interpolation : {Signal::Interpolation::linear, Signal::Interpolation::cubic}) {
    input.signal = table({0, 1, 1 + 1e-15}, {0, 1, 1e300}, interpolation);
    CHECK_THROWS_WITH(net.add_input(input),
                      doctest::Contains("from entry 1 of its table to the next it changes too fast"));
    input.signal = table({0, 1}, {-1e308, 1e308}, interpolation);
    CHECK_THROWS_WITH(net.add_input(input), doctest::Contains("from entry 0"));
  }
  input.signal = table({0, 1, 1 + 1e-15}, {0, 1, 1e300}, Signal::Interpolation::hold);
  CHECK_NOTHROW(net.add_input(input));
}

TEST_CASE("elements read signals, too") {
  Network net;
  for (const Vector3& at : {Vector3(1, 0, 0), Vector3(0, 0, 0), Vector3(0, 1, 0)}) net.add_node(point(at));
  const MaterialIndex material = net.add_material({LawUse{"motor", {}}, std::nullopt});
  for (int k = 0; k < 2; ++k) net.add_element(Invariant::angle, {0, 1, 2}, material);
  Input input;
  input.input = "tension";
  input.elements = {1};
  input.signal = constant(2.5);
  net.add_input(input);
  const Simulation simulation = simulate_with_inputs(net, recurrent(newton, 1e-9), 0.1);
  CHECK(simulation.element_force(0) == 0.0);
  CHECK(simulation.element_force(1) == 2.5);
  // On arms of 1 m: 2.5 N m is 2.5 N across each.
  CHECK(simulation.force(0).norm() == doctest::Approx(2.5).epsilon(1e-14));
}
