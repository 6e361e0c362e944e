// Irregular networks with every kind of law, in random states.
#pragma once

#include <random>
#include <vector>

#include "layers/evaluator.hpp"
#include "layers/layout.hpp"
#include "nets.hpp"

namespace springnet::testing {

// Nodes in a box at random, each joined to some others near it in number; laws with different stiffnesses, rest
// lengths, viscosities along the spring, along the relative velocity and none; two kinds of neurons.
inline Network random_network(std::uint32_t nodes, std::uint32_t springs_per_node, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Network net;
  const std::uint32_t dragged = net.add_neuron({"dragged", {{"drag", 0.3}}});
  std::vector<MaterialIndex> materials;
  for (int i = 0; i < 6; ++i) {
    const double k = 1.0 + i;
    const std::optional<LawUse> springs[] = {LawUse{"linear", {{"stiffness", k}}},
                                             LawUse{"nonlinear", {{"stiffness", k}, {"cubic", 2.0}}}, std::nullopt};
    const std::optional<LawUse> viscosities[] = {LawUse{"linear", {{"damping", 0.5 * k}}},
                                                 LawUse{"relative", {{"damping", 0.2 * k}}}};
    materials.push_back(net.add_material({springs[i % 3], viscosities[i % 2]}));
  }
  materials.push_back(net.add_material({LawUse{"linear", {{"stiffness", 2.0}}}, std::nullopt}));
  for (std::uint32_t k = 0; k < nodes; ++k) {
    Node node = point({unit(random), unit(random), unit(random)}, 0.5 + unit(random),
                      {unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5});
    node.neuron = k % 5 == 0 ? dragged : 0;
    net.add_node(node);
  }
  for (std::uint32_t k = 0; k < nodes; ++k) {
    for (std::uint32_t j = 0; j < springs_per_node; ++j) {
      const auto other = static_cast<std::uint32_t>((k + 1 + random() % 50) % nodes);
      if (other == k) continue;
      const double rest = random() % 3 == 0 ? 0.25 * static_cast<double>(1 + random() % 4) : 0.2 + unit(random);
      net.add_spring(k, other, materials[random() % materials.size()], rest);
    }
  }
  net.set_gravity({0.1, -0.2, -9.81});
  return net;
}

// A layout with the arrays that its evaluator works on, in the initial state of the network.
struct EvaluatorFixture {
  explicit EvaluatorFixture(const Network& net, InstructionSet set = InstructionSet::best, unsigned threads = 1,
                            bool renumber = true)
      : layout(net, *plugins(), renumber) {
    const std::size_t n = layout.node_count();
    for (std::vector<double>* arrays : {p, v, f})
      for (int c = 0; c < 3; ++c) arrays[c].assign(n, 0.0);
    for (std::size_t k = 0; k < n; ++k) {
      const Node& node = net.nodes()[layout.ordering().user[k]];
      mass.push_back(node.mass);
      for (std::size_t c = 0; c < 3; ++c) {
        p[c][k] = node.position[static_cast<Eigen::Index>(c)];
        v[c][k] = node.velocity[static_cast<Eigen::Index>(c)];
      }
    }
    external.gravity = net.gravity();
    evaluator = std::make_unique<layers::Evaluator>(layout, mass, set, threads);
  }
  [[nodiscard]] layers::NodeArrays nodes() const {
    return {p[0].data(), p[1].data(), p[2].data(), v[0].data(), v[1].data(), v[2].data()};
  }
  [[nodiscard]] layers::ForceArrays forces() { return {f[0].data(), f[1].data(), f[2].data()}; }
  void evaluate() {
    springnet_message message{};
    if (evaluator->evaluate(0.0, nodes(), external, forces(), {}, message) != SPRINGNET_OK)
      throw std::runtime_error(message.text);
  }
  // Of a node in the user's numbers.
  [[nodiscard]] Vector3 force(std::uint32_t user) const {
    const std::uint32_t k = layout.ordering().engine[user];
    return {f[0][k], f[1][k], f[2][k]};
  }

  layers::Layout layout;
  std::vector<double> mass, p[3], v[3], f[3];
  layers::ExternalForces external;
  std::unique_ptr<layers::Evaluator> evaluator;
};

}  // namespace springnet::testing
