// Irregular networks with all shipped laws, parameters at random over decades.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "nets.hpp"

namespace springnet::testing {

struct RandomNet {
  unsigned nodes;      // at least 2
  double decades;      // over which stiffness, damping and mass spread
  bool unique;         // laws whose force rises with the length only, as far as these nets stretch
  bool floor = false;  // falls on one
};

// The same bits on every platform: no distribution of the standard library is used.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  [[nodiscard]] double between(double from, double to) {
    return from + (to - from) * static_cast<double>(engine_() >> 5) * 0x1p-27;
  }
  [[nodiscard]] double decades(double middle, double count) {
    return middle * std::pow(10.0, between(-0.5, 0.5) * count);
  }
  [[nodiscard]] unsigned below(unsigned count) { return static_cast<unsigned>(engine_() % count); }

 private:
  std::mt19937 engine_;
};

inline LawUse random_spring(Random& random, const RandomNet& kind) {
  const double stiffness = random.decades(30.0, kind.decades);
  switch (random.below(4)) {
    case 0:
      return {"linear", {{"stiffness", stiffness}}};
    case 1:
      return {"nonlinear",
              {{"stiffness", stiffness}, {"cubic", (kind.unique ? 0.3 : random.between(-0.3, 0.3)) * stiffness}}};
    case 2:
      return {"exponential", {{"stiffness", stiffness}, {"exponent", random.between(0.5, kind.unique ? 3.0 : 10.0)}}};
    default:
      return {"rupturing", {{"stiffness", stiffness}, {"strength", kind.unique ? 1e6 * stiffness : 0.5 * stiffness}}};
  }
}

inline std::optional<LawUse> random_viscosity(Random& random, const RandomNet& kind) {
  const double damping = random.decades(1.0, kind.decades);
  switch (random.below(4)) {
    case 0:
      return LawUse{"linear", {{"damping", damping}}};
    case 1:
      return LawUse{"power", {{"damping", damping}, {"exponent", random.between(1.0, 2.0)}}};
    case 2:
      return LawUse{"relative", {{"damping", damping}}};
    default:
      return std::nullopt;
  }
}

// Nodes in a box, a metre apart or so; each joined to some near it. A few are fixed, some are in a viscous medium.
inline Network random_net(Random& random, const RandomNet& kind) {
  Network net;
  const double side = std::cbrt(static_cast<double>(kind.nodes));
  const std::uint32_t dragged = net.add_neuron({"dragged", {{"drag", random.decades(0.3, 2.0)}}});
  for (unsigned k = 0; k < kind.nodes; ++k) {
    const auto in_box = [&] { return random.between(0.0, side); };
    Node node = point(Vector3::Zero(), random.decades(1.0, 0.5 * kind.decades));
    // Not closer than half a metre to another, if that can be had.
    for (int tries = 0; tries < 30; ++tries) {
      const double x = in_box(), y = in_box(), z = in_box();
      node.position = {x, y, z + 0.01};
      bool is_clear = true;
      for (const Node& other : net.nodes()) is_clear = is_clear && (other.position - node.position).norm() > 0.5;
      if (is_clear) break;
    }
    const double u = random.between(-1.0, 1.0), v = random.between(-1.0, 1.0), w = random.between(-1.0, 1.0);
    node.velocity = {u, v, w};
    node.fixed = random.below(12) == 0;
    if (random.below(6) == 0) node.neuron = dragged;
    net.add_node(node);
  }
  std::vector<MaterialIndex> materials;
  for (int i = 0; i < 6; ++i) {
    LawUse spring = random_spring(random, kind);
    materials.push_back(net.add_material({std::move(spring), random_viscosity(random, kind)}));
  }
  const NodeList& nodes = net.nodes();
  for (NodeIndex a = 0; a < kind.nodes; ++a) {
    std::vector<NodeIndex> near;
    for (NodeIndex b = 0; b < kind.nodes; ++b)
      if (b != a) near.push_back(b);
    std::stable_sort(near.begin(), near.end(), [&](NodeIndex b, NodeIndex c) {
      return (nodes[b].position - nodes[a].position).norm() < (nodes[c].position - nodes[a].position).norm();
    });
    const unsigned count = 1 + random.below(5);
    for (unsigned i = 0; i < count && i < near.size(); ++i) {
      const double length = (nodes[near[i]].position - nodes[a].position).norm();
      const double rest = length * random.between(kind.unique ? 0.9 : 0.6, kind.unique ? 1.0 : 1.4);
      net.add_spring(a, near[i], materials[random.below(6)], rest);
    }
  }
  net.set_gravity({0, 0, -random.decades(3.0, 1.0)});
  if (kind.floor) net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  return net;
}

}  // namespace springnet::testing
