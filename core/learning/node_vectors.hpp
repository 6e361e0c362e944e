// Access to one node in a vector of all nodes: x of all of them in the engine's order, then y, then z.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <springnet/network.hpp>
#include <springnet/sdk/host.hpp>

namespace springnet::learning {

[[nodiscard]] inline Vector3 node_of(const Eigen::Ref<const Eigen::VectorXd>& of, std::uint32_t node) {
  const Eigen::Index n = of.size() / 3;
  return {of[node], of[n + node], of[2 * n + node]};
}
inline void put_node(Eigen::Ref<Eigen::VectorXd> to, std::uint32_t node, const Vector3& value) {
  const Eigen::Index n = to.size() / 3;
  for (Eigen::Index axis = 0; axis < 3; ++axis) to[axis * n + node] = value[axis];
}
inline void add_to_node(Eigen::Ref<Eigen::VectorXd> to, std::uint32_t node, const Vector3& change) {
  put_node(to, node, node_of(to, node) + change);
}
// Position and velocity of a node.
inline void put_state(Eigen::Ref<Eigen::VectorXd> p, Eigen::Ref<Eigen::VectorXd> v, std::uint32_t node,
                      const Vector3& position, const Vector3& velocity) {
  put_node(p, node, position);
  put_node(v, node, velocity);
}
// Places in such a vector of nodes whose motion is given.
inline void find_pinned(const springnet_network& network, std::vector<Eigen::Index>& places) {
  places.clear();
  const auto n = static_cast<Eigen::Index>(network.node_count);
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (Eigen::Index k = 0; k < n; ++k)
      if ((network.fixed[k] | network.held[k]) != 0) places.push_back(axis * n + k);
}

}  // namespace springnet::learning
