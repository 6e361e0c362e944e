// A net with springs and elements of several laws, inputs and neurons, as it is built and as it may be changed.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "generator.hpp"
#include "nets.hpp"

namespace springnet::testing {

// The values that setters change, [spring], [element] or [node].
struct Values {
  std::vector<double> stiffness, damping, rest_length, activation;  // activation: of the last `muscles` springs
  std::vector<double> bending, reference;
  std::vector<double> drag, mass;
};

inline constexpr std::size_t muscles = 3;

// A block of springs, equal at first or each by itself, with angles along its edges and muscles beside it.
class MixedNet {
 public:
  explicit MixedNet(bool regular, std::uint32_t side = 4) {
    Network net;
    Lattice lattice;
    lattice.nodes = {side, side, side};
    lattice.diagonals = Diagonals::face;
    Node node;
    node.neuron = net.add_neuron({"dragged", {{"drag", 0.1}}});
    net.add_lattice("block", lattice, node, net.add_material(damped(300.0, 2.0)));
    Dice dice(7);
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
      Node own = net.nodes()[k];
      own.position += dice.in_box(0.05);
      own.velocity = dice.in_box(0.3);
      net.set_node(k, own);
    }
    if (!regular)
      for (SpringIndex s = 0; s < net.springs().size(); ++s) net.set_rest_length(s, dice.between(0.9, 1.5));
    net.fix(0);
    for (std::size_t i = 0; i < muscles; ++i) {
      const NodeIndex a = net.add_node(point({6, 0, double(i)})), b = net.add_node(point({7, 0, double(i)}));
      net.add_spring(a, b,
                     net.add_material({LawUse{"muscle", {{"strength", 20.0}}}, LawUse{"linear", {{"damping", 2.0}}}}));
    }
    const MaterialIndex bending = net.add_material({LawUse{"linear", {{"stiffness", 5.0}}}, std::nullopt});
    for (NodeIndex k = 0; k + 2 < side * side; k += side) net.add_element(Invariant::angle, {k, k + 1, k + 2}, bending);
    base_ = net;
    const std::size_t springs = net.springs().size(), nodes = net.nodes().size();
    values.stiffness.assign(springs - muscles, 300.0);
    values.damping.assign(springs, 2.0);
    for (SpringIndex s = 0; s < springs; ++s) values.rest_length.push_back(net.springs()[s].rest_length);
    values.activation.assign(muscles, 0.0);
    values.bending.assign(net.elements().size(), 5.0);
    for (const Element& element : net.elements()) values.reference.push_back(element.reference);
    values.drag.assign(nodes - 2 * muscles, 0.1);
    values.mass.assign(nodes, 1.0);
  }

  [[nodiscard]] const Network& base() const { return base_; }
  // Built with the values; nodes where they are in a simulation, without the springs and elements it has lost.
  [[nodiscard]] Network built(const Simulation& at) const {
    Network net;
    for (NodeIndex k = 0; k < base_.nodes().size(); ++k) {
      Node node = base_.nodes()[k];
      node.position = at.position(k);
      if (!node.fixed) node.velocity = at.velocity(k);
      node.mass = values.mass[k];
      if (k < values.drag.size())
        node.neuron = net.add_neuron({"dragged", {{"drag", values.drag[k]}}});
      else
        node.neuron = 0;
      net.add_node(node);
    }
    const std::size_t first_muscle = values.stiffness.size();
    for (SpringIndex s = 0; s < base_.springs().size(); ++s) {
      if (!at.alive(s)) continue;
      const Spring spring = base_.springs()[s];
      Material material = damped(1.0, values.damping[s]);
      if (s < first_muscle)
        material.spring->parameters["stiffness"] = values.stiffness[s];
      else
        material.spring = LawUse{"muscle", {{"strength", 20.0}}};
      const SpringIndex own =
          net.add_spring(spring.first, spring.second, net.add_material(material), values.rest_length[s]);
      if (s < first_muscle) continue;
      Input input;
      input.input = "activation";
      input.springs = {own};
      input.signal.mean = values.activation[s - first_muscle];
      net.add_input(input);
    }
    for (ElementIndex e = 0; e < base_.elements().size(); ++e) {
      if (!at.element_alive(e)) continue;
      net.add_element(Invariant::angle, base_.elements()[e].nodes,
                      net.add_material({LawUse{"linear", {{"stiffness", values.bending[e]}}}, std::nullopt}),
                      values.reference[e]);
    }
    return net;
  }

  // A change of something, at random, of the values and of a simulation.
  void change(Dice& dice, Simulation& simulation) {
    const auto some = [&](std::size_t count) {
      std::vector<std::uint32_t> list;
      const std::uint32_t size = dice.chance(0.2) ? static_cast<std::uint32_t>(count) : 1 + dice.below(6);
      for (std::uint32_t i = 0; i < size; ++i)
        list.push_back(size == count ? i : dice.below(static_cast<std::uint32_t>(count)));
      return list;
    };
    const auto change = [&](std::vector<double>& of, double from, double to, const auto& set, std::uint32_t first = 0) {
      std::vector<std::uint32_t> list = some(of.size());
      const bool one = dice.chance(0.4);
      std::vector<double> own;
      for (const std::uint32_t each : list) {
        if (!one || own.empty()) own.push_back(dice.between(from, to));
        of[each] = own.back();
      }
      for (std::uint32_t& each : list) each += first;
      set(list, own);
    };
    const auto spring = ComponentKind::spring_function, viscosity = ComponentKind::viscosity_function;
    switch (dice.below(8)) {
      case 0:
        return change(values.stiffness, 100.0, 500.0,
                      [&](auto& list, auto& own) { simulation.set_parameter(list, spring, "stiffness", own); });
      case 1:
        return change(values.damping, 0.5, 4.0,
                      [&](auto& list, auto& own) { simulation.set_parameter(list, viscosity, "damping", own); });
      case 2:
        return change(values.rest_length, 0.9, 1.4,
                      [&](auto& list, auto& own) { simulation.set_rest_lengths(list, own); });
      case 3:
        return change(
            values.activation, 0.0, 1.0,
            [&](auto& list, auto& own) { simulation.set_law_input(list, spring, "activation", own); },
            static_cast<std::uint32_t>(values.stiffness.size()));
      case 4:
        return change(values.bending, 1.0, 9.0,
                      [&](auto& list, auto& own) { simulation.set_element_parameter(list, spring, "stiffness", own); });
      case 5:
        return change(values.reference, 1.0, 2.0, [&](auto& list, auto& own) { simulation.set_references(list, own); });
      case 6:
        return change(values.drag, 0.0, 0.5,
                      [&](auto& list, auto& own) { simulation.set_neuron_parameter(list, "drag", own); });
      default:
        return change(values.mass, 0.5, 2.0, [&](auto& list, auto& own) { simulation.set_masses(list, own); });
    }
  }

  Values values;

 private:
  Network base_;
};

// Greatest difference of the positions, m.
inline double distance(const Simulation& a, const Simulation& b) {
  double most = 0.0;
  for (NodeIndex k = 0; k < std::min(a.node_count(), b.node_count()); ++k)
    most = std::max(most, (a.position(k) - b.position(k)).norm());
  return most;
}
inline double force_difference(const Simulation& a, const Simulation& b) {
  double most = 0.0;
  for (NodeIndex k = 0; k < std::min(a.node_count(), b.node_count()); ++k)
    most = std::max(most, (a.force(k) - b.force(k)).norm());
  return most;
}

// Integrators and their time steps, s.
inline std::vector<std::pair<LawUse, double>> all_integrators() {
  std::vector<std::pair<LawUse, double>> all;
  for (const double theta : {1.0, 0.5})
    for (const double rule : {synchronous, wavefront, block, coloured, newton, automatic})
      all.emplace_back(recurrent(rule, 1e-11, {{"theta", theta}}), 0.002);
  all.emplace_back(cvode(1e-10), 0.01);
  all.emplace_back(LawUse{"verlet", {{"substeps", 10}}}, 0.01);
  all.emplace_back(testing::generalized_alpha(), 0.01);
  return all;
}

}  // namespace springnet::testing
