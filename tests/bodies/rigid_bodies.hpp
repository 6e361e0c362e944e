// Bodies of rigidly connected nodes, and every integrator that keeps them apart.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bodies.hpp"

namespace springnet::testing {

inline void join(Network& net, NodeIndex first, NodeIndex count) {
  for (NodeIndex i = first; i < first + count; ++i)
    for (NodeIndex j = first; j < i; ++j) net.add_rigid(i, j);
}

// A rigid box of eight nodes, two triangles a side, outwards, whose faces are twice this radius thick: its body's
// number.
inline std::size_t add_box(Network& net, const std::string& name, const Vector3& origin, const Vector3& size,
                           double mass, double radius, const Vector3& velocity = Vector3::Zero()) {
  net.begin_body(name);
  const auto first = static_cast<NodeIndex>(net.nodes().size());
  for (int k = 0; k < 8; ++k)
    net.add_node(point(origin + Vector3(k & 1, k >> 1 & 1, k >> 2).cwiseProduct(size), mass / 8.0, velocity));
  constexpr std::array<std::array<NodeIndex, 4>, 6> sides{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& side : sides) {
    net.add_face({first + side[0], first + side[1], first + side[2]});
    net.add_face({first + side[0], first + side[2], first + side[3]});
  }
  net.end_body();
  net.set_extent(net.bodies().size() - 1, 2.0 * radius, 0.0);
  join(net, first, 8);
  return net.bodies().size() - 1;
}

struct Method {
  std::string name;
  LawUse integrator;
  double theta;  // 0.5: of second order
  bool network = true;
};
// Of the network every rule with both theta; verlet; the reference.
inline std::vector<Method> methods(double force_tolerance) {
  std::vector<Method> result{{"verlet", verlet, 0.5, false}, {"cvode", reference(1e-9), 0.5, false}};
  for (const std::string rule : update_rules)
    for (const double theta : {1.0, 0.5}) {
      const LawUse integrator = recurrent(update_named(rule), force_tolerance, {{"theta", theta}});
      result.push_back({rule + ", theta " + std::to_string(theta), integrator, theta});
    }
  return result;
}

}  // namespace springnet::testing
