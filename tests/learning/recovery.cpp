// Parameters that were known are recovered from the motion they gave.

#include <cmath>
#include <memory>
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

}  // namespace

TEST_CASE("the cube's 252 stiffnesses, 252 dampings and 63 masses are recovered from its motion") {
  const Network real = cube_in_space(true), guess = cube_in_space(false);
  const std::size_t springs = real.springs().size(), nodes = real.nodes().size();
  REQUIRE(springs == 252);
  const Truth known = truth(springs);
  Simulation simulation(real, plugins(), to_learn_with(1.0, 0.05));
  const std::vector<std::uint32_t> all = from_to(0, springs);
  simulation.set_parameter(all, ComponentKind::spring_function, "stiffness", known.stiffness);
  simulation.set_parameter(all, ComponentKind::viscosity_function, "damping", known.damping);
  const Experiment seen = experiment(guess, to_learn_with(1.0, 0.05), observe(simulation, 20, from_to(0, nodes)));
  const std::vector<Learnable> learnables{{{Kind::spring_parameter, false, "stiffness", all}},
                                          {{Kind::viscosity_parameter, false, "damping", all}},
                                          {{Kind::mass, false, "", from_to(1, nodes)}}};
  const LearnedNet learned = learn({seen}, plugins(), learnables);
  CAPTURE(learned.reason);
  CHECK(learned.variables == 567);
  CHECK(learned.undetermined == 0);
  double worst = 0.0;
  for (const LearnedParameter& each : learned.parameters) {
    const double right = each.kind == Kind::mass               ? real.nodes()[each.member].mass
                         : each.kind == Kind::spring_parameter ? known.stiffness[each.member]
                                                               : known.damping[each.member];
    worst = std::max(worst, std::abs(each.value / right - 1.0));
  }
  CHECK(worst < 1e-6);
  // Steps and systems are solved to 1e-11 of their size; the condition is about 2000.
  CHECK(learned.singular_values.front() < 1e4 * learned.singular_values.back());
}
