// A net on a floor: nodes that slide, alone and joined by rigid connections, nodes that stick, and a fixed one.
#pragma once

#include "host_at.hpp"

namespace springnet::testing {

struct OnFloor {
  Friction friction{Friction::Kind::coulomb, 0.3};
  bool rigid = false;
  bool at_rest = false;  // nodes 0 to 5, which pull at each other so strongly that slips begin
};

// Sets: stiffness by springs, mass by nodes.
inline Parametrised on_floor(const OnFloor& what) {
  Parametrised given;
  const Eigen::VectorXd x = random_vector(200, 41);
  Values mass, stiffness;
  for (std::size_t k = 0; k < 12; ++k) mass.push_back(1.0 + 0.05 * static_cast<double>(k));
  for (std::size_t s = 0; s < 26; ++s) stiffness.push_back(8.0 + x[static_cast<Eigen::Index>(s)]);
  given.sets.resize(2);
  given.sets[0].set.kind = SPRINGNET_BY_SPRING_PARAMETER;
  given.sets[0].set.parameter = "stiffness";
  given.sets[0].values = stiffness;
  given.sets[1].set.kind = SPRINGNET_BY_MASS;
  given.sets[1].values = mass;
  given.sets[1].of_nodes = true;
  given.make = [what, x](const std::vector<Parametrised::Set>& sets) {
    Network net;
    net.set_gravity({0, 0, -9.81});
    Plane floor{"floor", Vector3::Zero(), Vector3::UnitZ()};
    floor.friction = what.friction;
    net.add_plane(floor);
    for (NodeIndex k = 0; k < 12; ++k) {
      const auto i = static_cast<Eigen::Index>(6 * k);
      // 0 to 5 slide on the floor, 6 and 7 rest on it, the others are above it.
      Vector3 p(2.0 * std::cos(0.5 * k), 2.0 * std::sin(0.5 * k), 0.0), v = x.segment<3>(i);
      v[2] = 0.0;
      if (k >= 6 || what.at_rest) v.setZero();
      if (k >= 8) p = Vector3(x[i], x[i + 1], 1.0 + 0.3 * x[i + 2]), v = x.segment<3>(i + 3);
      Node node = point(p, sets[1].values[k], v);
      net.add_node(node);
    }
    net.fix(11);
    std::size_t s = 0;
    for (NodeIndex k = 0; k < 12; ++k)
      for (NodeIndex step = 1; step <= 3 && k + step < 12; ++step) {
        if (s >= sets[0].values.size()) continue;
        const bool strong = what.at_rest && k < 6;
        // Few springs lead to 6 and 7, so that they stick.
        if (k < 8 && k + step >= 6 && k + step < 8) continue;
        if (k >= 6 && k < 8) continue;
        net.add_spring(k, k + step,
                       net.add_material({LawUse{"linear", {{"stiffness", sets[0].values[s++]}}},
                                         LawUse{"linear", {{"damping", 0.2}}}}),
                       strong ? 0.3 : 1.0);
      }
    for (; s < sets[0].values.size(); ++s) {  // all stiffnesses are of springs
      const auto k = static_cast<NodeIndex>(8 + s % 2);
      net.add_spring(k, 10, net.add_material({LawUse{"linear", {{"stiffness", sets[0].values[s]}}}, std::nullopt}),
                     1.0);
    }
    if (what.rigid) {
      // Motions that keep these lengths.
      net.add_rigid(1, 8);
      net.add_rigid(8, 9);
      net.add_rigid(9, 4);
    }
    return net;
  };
  return given;
}

}  // namespace springnet::testing
