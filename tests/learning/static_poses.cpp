// Static poses as data: a net at rest under its loads, observed once. A motion whose few steps are far longer than its
// slowest oscillation ends there; CVODE, which comes to rest by real damping, says where that is.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include "learning_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// The slowest oscillation takes some seconds. A step of theta 1 leaves 1/(h omega)^2, some 1e-5, of what is not at
// rest, and each one after it as much of that.
constexpr double step = 100.0, end = 400.0;  // s

constexpr NodeIndex held_nodes = 4;

// A lattice that hangs from its four highest nodes. Springs along the axes that are upright, that are level, and
// diagonals: three groups.
struct Hanging {
  explicit Hanging(std::uint32_t layers) {
    Network lattice_alone;
    Lattice lattice;
    lattice.nodes = {2, 2, layers};
    lattice.diagonals = Diagonals::face;
    lattice_alone.add_lattice("block", lattice, Node{}, lattice_alone.add_material(damped(1.0, 1.0)));
    Dice dice(7);
    for (const Node& node : lattice_alone.nodes())  // the layer of the first ones is the highest
      net.add_node(point({node.position.x(), node.position.y(), -node.position.z()}, dice.between(0.5, 2.0)));
    for (NodeIndex k = 0; k < held_nodes; ++k) net.fix(k);
    for (std::size_t group = 0; group < 3; ++group) net.add_material(damped(stiffness[group], 20.0));
    for (const Spring& each : lattice_alone.springs()) {
      const Vector3 way = lattice_alone.nodes()[each.first].position - lattice_alone.nodes()[each.second].position;
      const std::uint32_t group = way.norm() > 1.1 ? 2 : std::abs(way.z()) > 0.5 ? 0 : 1;
      groups[group].push_back(net.add_spring(each.first, each.second, group));
    }
    net.set_gravity({0, 0, -2.0});
  }
  // Loads on all nodes that are free.
  void push(std::uint64_t seed) {
    Dice dice(seed);
    for (NodeIndex k = held_nodes; k < net.nodes().size(); ++k) {
      Load load;
      load.nodes = {k};
      load.force = dice.in_box(8.0);
      net.add_load(load);
    }
  }

  static constexpr std::array<double, 3> stiffness{90.0, 60.0, 40.0};
  Network net;
  std::array<std::vector<std::uint32_t>, 3> groups;
};

// Positions at rest of all nodes that are free, for the end of the motion that learns.
Observations pose(const Network& net, const std::vector<double>& stiffness = {}) {
  Simulation real = simulate(net, cvode(1e-11), 0.5);
  if (!stiffness.empty())
    real.set_parameter(from_to(0, stiffness.size()), ComponentKind::spring_function, "stiffness", stiffness);
  real.advance_to(150.0);
  Observations result;
  for (NodeIndex k = held_nodes; k < net.nodes().size(); ++k) {
    CHECK(real.velocity(k).norm() < 1e-9);  // m/s
    result.positions.push_back(row(end, k, real.position(k)));
  }
  return result;
}

Network with_stiffness(const Network& net, const std::vector<double>& stiffness) {
  Simulation simulation(net, plugins(), to_learn_with(1.0, step));
  simulation.set_parameter(from_to(0, stiffness.size()), ComponentKind::spring_function, "stiffness", stiffness);
  return simulation.present_network();
}

}  // namespace

TEST_CASE("stiffnesses of groups are learned from one static pose of a net whose masses are known") {
  const Hanging real(4);
  std::vector<double> guess(real.net.springs().size());
  std::vector<Learnable> learnables;
  constexpr double factors[] = {0.4, 2.0, 1.5};
  for (std::size_t group = 0; group < 3; ++group) {
    for (const std::uint32_t s : real.groups[group]) guess[s] = factors[group] * Hanging::stiffness[group];
    learnables.push_back({{Kind::spring_parameter, false, "stiffness", real.groups[group]}, true});
  }
  const LearnedNet learned = learn(
      {experiment(with_stiffness(real.net, guess), to_learn_with(1.0, step), pose(real.net))}, plugins(), learnables);
  CAPTURE(learned.reason);
  CHECK(learned.variables == 3);
  CHECK(learned.undetermined == 0);
  for (std::size_t group = 0; group < 3; ++group)
    for (const LearnedParameter& each : learned.parameters) {
      if (each.member != real.groups[group].front()) continue;
      CAPTURE(group);
      CHECK(each.value == doctest::Approx(Hanging::stiffness[group]).epsilon(1e-6));
      CHECK(std::abs(each.by_time_step) < 1e-6 * each.value);  // a pose has no error of the time step
    }
}

TEST_CASE("two poses under different loads determine each stiffness, of which one leaves some undetermined") {
  Hanging pulled(3), pushed(3);
  pulled.push(1);
  pushed.push(2);
  const std::size_t springs = pulled.net.springs().size();
  Dice dice(3);
  std::vector<double> stiffness, guess(springs, 60.0);
  for (std::size_t s = 0; s < springs; ++s) stiffness.push_back(60.0 * dice.decades(0.7, 1.4));
  std::vector<std::uint32_t> free;  // springs that are not between held nodes
  for (std::uint32_t s = 0; s < springs; ++s)
    if (pulled.net.springs()[s].first >= held_nodes || pulled.net.springs()[s].second >= held_nodes) free.push_back(s);
  const std::vector<Learnable> each_one{{{Kind::spring_parameter, false, "stiffness", free}}};
  const auto experiment_of = [&](const Hanging& own) {
    return experiment(with_stiffness(own.net, guess), to_learn_with(1.0, step), pose(own.net, stiffness));
  };
  // Equations of equilibrium: three for each node that is free.
  const std::size_t equations = 3 * (pulled.net.nodes().size() - held_nodes);
  REQUIRE(equations < free.size());
  REQUIRE(free.size() <= 2 * equations);
  const LearnedNet from_one = learn({experiment_of(pulled)}, plugins(), each_one);
  CHECK(from_one.rms < 1e-8);
  CHECK(from_one.undetermined == free.size() - equations);
  const LearnedNet from_both = learn({experiment_of(pulled), experiment_of(pushed)}, plugins(), each_one);
  CAPTURE(from_both.reason);
  CHECK(from_both.undetermined == 0);
  double worst = 0.0;
  for (const LearnedParameter& each : from_both.parameters)
    worst = std::max(worst, std::abs(each.value / stiffness[each.member] - 1.0));
  MESSAGE("greatest relative error: ", worst);
  CHECK(worst < 1e-6);
}

TEST_CASE("a static pose says nothing about dampings, and nothing about masses without stiffnesses") {
  const Hanging real(3);
  const std::vector<std::uint32_t> springs = from_to(0, real.net.springs().size());
  const LearnedNet learned = learn({experiment(real.net, to_learn_with(1.0, step), pose(real.net))}, plugins(),
                                   {{{Kind::spring_parameter, false, "stiffness", springs}, true},
                                    {{Kind::viscosity_parameter, false, "damping", springs}, true},
                                    {{Kind::mass, false, "", from_to(held_nodes, real.net.nodes().size())}, true}});
  CHECK(learned.variables == 3);
  CHECK(learned.undetermined == 2);
  for (const LearnedParameter& each : learned.parameters) {
    if (each.kind == Kind::viscosity_parameter)
      CHECK(each.determined < 1e-6);
    else
      CHECK(each.determined == doctest::Approx(0.5).epsilon(1e-3));  // the ratio of both, in logarithms
  }
}
