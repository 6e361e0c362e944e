// Small nets at random whose motion has derivatives of every order, so that orders of methods show: no law at a kink of
// its force or of its slope.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "generator.hpp"
#include "nets.hpp"

namespace springnet::testing {

// Eight nodes about the corners of a cube, each with springs to its nearest, which move apart: every spring is longer
// than at rest, and becomes longer.
class ExpandingNet {
 public:
  explicit ExpandingNet(std::uint64_t seed) : dice_(seed) {
    for (int k = 0; k < 8; ++k) {
      const Vector3 corner(k & 1, (k >> 1) & 1, (k >> 2) & 1);
      const Vector3 place = corner + dice_.in_box(0.15);
      net.add_node(point(place, dice_.between(0.6, 1.5), 0.8 * (place - Vector3(0.5, 0.5, 0.5)) + dice_.in_box(0.05)));
    }
  }
  void join(const Material& material) {
    const MaterialIndex index = net.add_material(material);
    for (NodeIndex k = 0; k < 8; ++k)
      for (std::size_t i = 0; i < 4; ++i) {
        const NodeIndex other = nearest_nodes(net, k)[i];
        const double length = (net.nodes()[k].position - net.nodes()[other].position).norm();
        net.add_spring(k, other, index, dice_.between(0.93, 0.98) * length);
      }
  }
  // Elements of a law that fits them.
  void add(Invariant invariant, const std::vector<std::vector<NodeIndex>>& all, const Material& material) {
    const MaterialIndex index = net.add_material(material);
    for (const std::vector<NodeIndex>& nodes : all) {
      const ElementIndex element = net.add_element(invariant, nodes, index);
      net.set_reference(element, dice_.between(0.9, 0.97) * net.elements()[element].reference);
    }
  }
  // Elements of a law over several scalars, at rest in a somewhat smaller shape.
  void add_at_rest(Invariant shape, const std::vector<std::vector<NodeIndex>>& all, const Material& material,
                   const Vector3& direction = Vector3::Zero()) {
    const MaterialIndex index = net.add_material(material);
    for (const std::vector<NodeIndex>& nodes : all) {
      std::vector<Vector3> rest;
      for (const NodeIndex node : nodes) rest.push_back(0.95 * net.nodes()[node].position + dice_.in_box(0.01));
      net.add_element(shape, nodes, index, std::move(rest), direction);
    }
  }

  static std::vector<std::vector<NodeIndex>> triangles() { return {{0, 1, 2}, {1, 3, 2}, {4, 6, 5}, {5, 6, 7}}; }
  static std::vector<std::vector<NodeIndex>> hinges() { return {{1, 2, 3, 0}, {5, 6, 4, 7}, {0, 4, 1, 2}}; }
  static std::vector<std::vector<NodeIndex>> chains() { return {{1, 0, 2}, {3, 7, 5}, {0, 4, 6}}; }
  static std::vector<std::vector<NodeIndex>> tetrahedra() {
    return {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 1, 4, 7}, {6, 2, 7, 4}, {1, 2, 4, 7}};
  }
  // The surface of the cube, outwards.
  static std::vector<std::vector<NodeIndex>> surface() {
    return {
        {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5}};
  }

  Network net;

 private:
  Dice dice_;
};

// Of shipped laws without memory, elements of every invariant, gravity, drag, loads of which one begins on the way, a
// fixed node and one whose motion is given.
inline Network smooth_net(std::uint64_t seed) {
  Network net;
  Dice dice(seed);
  const std::uint32_t dragged = net.add_neuron({"dragged", {{"drag", dice.between(0.05, 0.3)}}});
  const std::uint32_t count = 9 + dice.below(5);
  while (net.nodes().size() < count) {
    Node node = point(dice.in_box(1.1), dice.between(0.5, 2.0), dice.in_box(0.5));
    bool apart = true;
    for (const Node& other : net.nodes()) apart = apart && (node.position - other.position).norm() > 0.55;
    if (!apart) continue;
    if (dice.chance(0.4)) node.neuron = dragged;
    net.add_node(node);
  }
  std::vector<MaterialIndex> materials;
  for (const LawUse& spring :
       {LawUse{"linear", {{"stiffness", dice.between(10.0, 30.0)}}},
        LawUse{"nonlinear", {{"stiffness", 15.0}, {"cubic", dice.between(10.0, 30.0)}, {"quintic", 5.0}}},
        LawUse{"exponential", {{"stiffness", dice.between(5.0, 15.0)}, {"exponent", 2.0}}},
        LawUse{"rupturing", {{"stiffness", 20.0}, {"strength", 1e4}}}})
    for (const LawUse& viscosity : {LawUse{"linear", {{"damping", dice.between(0.1, 0.6)}}},
                                    LawUse{"power", {{"damping", 0.4}, {"exponent", 3.0}}},
                                    LawUse{"relative", {{"damping", dice.between(0.05, 0.2)}}}})
      materials.push_back(net.add_material({spring, viscosity}));
  for (NodeIndex k = 0; k < count; ++k)
    for (std::size_t i = 0; i < 4; ++i) {
      const NodeIndex other = nearest_nodes(net, k)[i];
      const double length = (net.nodes()[k].position - net.nodes()[other].position).norm();
      net.add_spring(k, other, materials[dice.below(static_cast<std::uint32_t>(materials.size()))],
                     dice.between(0.9, 1.1) * length);
    }
  const MaterialIndex soft = net.add_material(
      {LawUse{"linear", {{"stiffness", dice.between(2.0, 5.0)}}}, LawUse{"linear", {{"damping", 0.1}}}});
  for (const Invariant kind :
       {Invariant::angle, Invariant::dihedral, Invariant::area, Invariant::volume, Invariant::enclosed_volume}) {
    std::vector<NodeIndex> nodes = nearest_nodes(net, dice.below(count));
    nodes.resize(kind == Invariant::angle || kind == Invariant::area ? 3 : 4);
    if (kind == Invariant::enclosed_volume)
      nodes = {nodes[0], nodes[2], nodes[1], nodes[0], nodes[1], nodes[3],
               nodes[1], nodes[2], nodes[3], nodes[2], nodes[0], nodes[3]};
    const ElementIndex element = net.add_element(kind, nodes, soft);
    net.set_reference(element, dice.between(0.85, 1.15) * net.elements()[element].reference);
  }
  net.fix(0);
  Move move;
  move.nodes = {1};
  move.motion.amplitude = dice.in_box(0.1);
  move.motion.frequency = 0.7;
  net.add_move(move);
  net.add_load({{2, 3}, dice.in_box(2.0), 0.1, 0.3});
  Load swaying{{4}, dice.in_box(3.0)};
  swaying.course.frequency = 1.0;
  net.add_load(swaying);
  net.set_gravity({0, 0, -2.0});
  return net;
}

}  // namespace springnet::testing
