// Irregular networks at random, the same on every platform: all shipped laws, parameters over six decades, elements of
// all invariants, fixed and moved nodes, loads, planes, rigid connections.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

namespace springnet::testing {

// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014). The standard library's distributions differ between platforms.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  double between(double from, double to) { return from + (to - from) * static_cast<double>(next() >> 11) * 0x1p-53; }
  // Uniform in the logarithm.
  double decades(double from, double to) { return std::pow(10.0, between(std::log10(from), std::log10(to))); }
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(next() % count); }
  bool chance(double probability) { return between(0.0, 1.0) < probability; }
  Vector3 in_box(double half) {
    const double x = between(-half, half), y = between(-half, half), z = between(-half, half);
    return {x, y, z};
  }

 private:
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

// The other nodes, by distance.
inline std::vector<NodeIndex> nearest_nodes(const Network& network, NodeIndex node) {
  std::vector<NodeIndex> others;
  for (NodeIndex k = 0; k < network.nodes().size(); ++k) {
    if (k != node) others.push_back(k);
  }
  const auto distance = [&](NodeIndex k) {
    return (network.nodes()[k].position - network.nodes()[node].position).squaredNorm();
  };
  std::sort(others.begin(), others.end(), [&](NodeIndex a, NodeIndex b) { return distance(a) < distance(b); });
  return others;
}

class RandomNet {
 public:
  // smallest_share: of the greatest stiffness, damping and mass.
  explicit RandomNet(std::uint64_t seed, double smallest_share = 1e-6) : range_(smallest_share), dice_(seed) {
    add_nodes();
    add_springs();
    Dice own(seed + 3000000);  // leaves the rest of the net unchanged by elements
    std::swap(own, dice_);
    if (dice_.chance(0.3)) add_elements();
    std::swap(own, dice_);
    if (dice_.chance(0.25)) add_rigids();
    if (dice_.chance(0.4)) add_plane();
    if (dice_.chance(0.2)) move_some();
    if (dice_.chance(0.3)) load_some();
    if (dice_.chance(0.8)) network.set_gravity(Vector3(0.0, 0.0, -dice_.decades(0.1, 100.0)));
  }

  Network network;

 private:
  static constexpr double max_stiffness = 1e4, max_damping = 1e2, max_mass = 1e2;  // N/m, N s/m, kg
  double range_;

  void add_nodes() {
    const auto count = static_cast<NodeIndex>(std::lround(dice_.decades(2.0, 200.0)));
    const double half = 0.5 * std::cbrt(count);  // about one node per cubic metre
    const std::uint32_t dragged = network.add_neuron({"dragged", {{"drag", dice_.decades(1e-3, 1.0)}}});
    for (NodeIndex k = 0; k < count; ++k) {
      Node node;
      node.position = dice_.in_box(half);
      node.velocity = dice_.in_box(1.0);
      node.mass = dice_.decades(range_ * max_mass, max_mass);
      if (dice_.chance(0.2)) node.neuron = dragged;
      const NodeIndex index = network.add_node(node);
      if (dice_.chance(0.1)) network.fix(index);
    }
  }

  LawUse spring_function() {
    const double stiffness = dice_.decades(range_ * max_stiffness, max_stiffness);
    switch (dice_.below(4)) {
      case 0:
        return {"linear", {{"stiffness", stiffness}}};
      case 1:  // a third of them soften when stretched
        return {"nonlinear",
                {{"stiffness", stiffness}, {"cubic", dice_.between(-0.5, 1.0) * stiffness}, {"quintic", 0.0}}};
      case 2:
        return {"exponential", {{"stiffness", stiffness}, {"exponent", dice_.between(0.1, 10.0)}}};
      default:
        return {"rupturing",
                {{"stiffness", stiffness},
                 {"strength", stiffness * dice_.decades(0.05, 5.0)},
                 {"breaks_in_compression", 0.0}}};
    }
  }
  LawUse viscosity_function() {
    const double damping = dice_.decades(range_ * max_damping, max_damping);
    switch (dice_.below(3)) {
      case 0:
        return {"linear", {{"damping", damping}}};
      case 1:
        return {"power", {{"damping", damping}, {"exponent", dice_.between(0.6, 2.5)}, {"linear_below", 1e-3}}};
      default:
        return {"relative", {{"damping", damping}}};
    }
  }

  void add_springs() {
    std::vector<MaterialIndex> materials;
    for (int i = 0; i < 8; ++i) {
      Material material{spring_function(), std::nullopt};
      if (dice_.chance(0.6)) material.viscosity = viscosity_function();
      if (dice_.chance(0.1)) material = {std::nullopt, viscosity_function()};
      materials.push_back(network.add_material(material));
    }
    const auto count = static_cast<NodeIndex>(network.nodes().size());
    for (NodeIndex k = 0; k < count; ++k) {
      const std::vector<NodeIndex> near = nearest(k);
      const std::size_t wanted = 1 + dice_.below(6);
      for (std::size_t i = 0; i < std::min(wanted, near.size()); ++i) {
        const double length = (network.nodes()[k].position - network.nodes()[near[i]].position).norm();
        const double stretch = dice_.chance(0.5) ? 1.0 : dice_.between(0.7, 1.3);
        network.add_spring(k, near[i], materials[dice_.below(8)], length / stretch);
      }
    }
  }
  // Forces of the order of springs', for shapes of about a metre: the same stiffness in N m/rad, N/m^3, N/m^5.
  void add_elements() {
    const auto count = static_cast<std::uint32_t>(network.nodes().size());
    if (count < 5) return;
    for (std::uint32_t i = 0; i < 1 + count / 4; ++i) {
      const std::vector<NodeIndex> near = nearest(dice_.below(count));
      Material material{LawUse{"linear", {{"stiffness", dice_.decades(range_ * max_stiffness, 1e-2 * max_stiffness)}}},
                        std::nullopt};
      if (dice_.chance(0.5))
        material.viscosity = LawUse{"linear", {{"damping", dice_.decades(range_ * max_damping, 1e-2 * max_damping)}}};
      const MaterialIndex index = network.add_material(material);
      static constexpr Invariant kinds[] = {Invariant::angle, Invariant::dihedral, Invariant::area, Invariant::volume,
                                            Invariant::enclosed_volume};
      const Invariant kind = kinds[dice_.below(5)];
      std::vector<NodeIndex> nodes(near.begin(), near.begin() + 4);
      if (kind == Invariant::angle || kind == Invariant::area) nodes.resize(3);
      if (kind == Invariant::enclosed_volume) {
        const NodeIndex a = nodes[0], b = nodes[1], c = nodes[2], d = nodes[3];
        nodes = {a, c, b, a, b, d, b, c, d, c, a, d};
      }
      const ElementIndex e = network.add_element(kind, nodes, index);
      if (dice_.chance(0.5)) network.set_reference(e, network.elements()[e].reference * dice_.between(0.8, 1.2));
    }
  }

  [[nodiscard]] std::vector<NodeIndex> nearest(NodeIndex node) const { return nearest_nodes(network, node); }

  // Pairs, chains and triangles.
  void add_rigids() {
    const auto count = static_cast<std::uint32_t>(network.nodes().size());
    std::vector<bool> used(count);
    for (std::uint32_t i = 0; i < 1 + count / 10; ++i) {
      const NodeIndex a = dice_.below(count);
      const std::vector<NodeIndex> near = nearest(a);
      const std::size_t members = std::min<std::size_t>(1 + dice_.below(2), near.size());
      bool free = !used[a];
      for (std::size_t j = 0; j < members; ++j) free = free && !used[near[j]];
      if (!free) continue;
      used[a] = true;
      for (std::size_t j = 0; j < members; ++j) {
        used[near[j]] = true;
        network.add_rigid(a, near[j]);
      }
      if (members == 2 && dice_.chance(0.3)) network.add_rigid(near[0], near[1]);
    }
  }

  void add_plane() {
    double lowest = 0.0;
    for (const Node& node : network.nodes()) lowest = std::min(lowest, node.position.z());
    Plane plane;
    plane.name = "floor";
    plane.point = {0.0, 0.0, lowest - (dice_.chance(0.5) ? 0.0 : dice_.decades(1e-3, 1e-1))};
    switch (dice_.below(3)) {
      case 0:
        plane.friction.kind = Friction::Kind::held;
        break;
      case 1:
        plane.friction.kind = Friction::Kind::none;
        break;
      default:
        plane.friction = {Friction::Kind::coulomb, dice_.between(0.1, 1.0)};
    }
    network.add_plane(plane);
  }

  void move_some() {
    const auto count = static_cast<std::uint32_t>(network.nodes().size());
    Move move;
    for (std::uint32_t i = 0; i < 1 + count / 30; ++i) {
      const NodeIndex node = dice_.below(count);
      if (std::find(move.nodes.begin(), move.nodes.end(), node) == move.nodes.end()) move.nodes.push_back(node);
    }
    move.motion.amplitude = dice_.in_box(0.1);
    move.motion.amplitude.z() = std::abs(move.motion.amplitude.z());  // does not start into the floor
    move.motion.frequency = dice_.decades(0.1, 10.0);
    network.add_move(move);
  }

  void load_some() {
    Load load;
    load.nodes = {dice_.below(static_cast<std::uint32_t>(network.nodes().size()))};
    load.force = dice_.in_box(dice_.decades(1e-2, 1e2));
    network.add_load(load);
  }

  Dice dice_;
};

}  // namespace springnet::testing
