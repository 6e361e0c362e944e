// Who is joined to whom, and the orders in which update rules visit the nodes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <springnet/network.hpp>

#include "inspection/linearised.hpp"

namespace springnet {

inline constexpr std::uint32_t no_cluster = 0xffffffffu;

// One end of a spring or of a rigid connection, or another node of an element, seen from the node there.
struct Joint {
  NodeIndex other;
  SpringIndex spring;  // no_spring: rigid, or by an element
};
inline constexpr SpringIndex no_spring = 0xffffffffu;

class Joints {
 public:
  explicit Joints(const Network& network);
  // By rising number of the other node.
  [[nodiscard]] std::span<const Joint> of(NodeIndex node) const {
    return {joints_.data() + start_[node], joints_.data() + start_[node + 1]};
  }
  [[nodiscard]] std::size_t count() const { return joints_.size(); }
  [[nodiscard]] std::size_t node_count() const { return start_.size() - 1; }

 private:
  std::vector<std::size_t> start_;
  std::vector<Joint> joints_;
};

// For each node the number of the set of nodes that rigid connections join, no_cluster if it is in none.
[[nodiscard]] std::vector<std::uint32_t> rigid_clusters(const Network& network);

// All nodes, breadth first from the free node with the greatest force at the start; parts that it does not reach follow
// from their own strongest node, the part with the greatest such force first. Ties go to the lower number. As the
// first sweep of a run.
[[nodiscard]] std::vector<NodeIndex> wave_order(const Joints& joints, const std::vector<LinearNode>& nodes);

// All nodes by colour: each node gets the first colour that none of its neighbours has, nodes of a cluster the same.
[[nodiscard]] std::vector<NodeIndex> colour_order(const Joints& joints, const std::vector<std::uint32_t>& clusters);

}  // namespace springnet
