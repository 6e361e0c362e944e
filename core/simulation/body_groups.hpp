// Bodies in contact as islands: pairs that share nodes which can move, or rigidly connected ones, with the obstacles
// that these nodes touch.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "constraints/pair_motion.hpp"
#include "simulation/model.hpp"
#include "simulation/struck_clusters.hpp"

namespace springnet {

struct BodyGroup {
  std::vector<std::size_t> pairs;    // places in the list that the group is of, ascending
  std::vector<std::uint32_t> nodes;  // of these and of their clusters, ascending, that can move
};
// Pairs without nodes that can move are in none.
[[nodiscard]] std::vector<BodyGroup> body_groups(const Model& model, const std::vector<PairMotion>& pairs);

// What an impulse acts on: a node, or the nodes of a pair with their weights.
struct Lever {
  explicit Lever(std::uint32_t node) : nodes{node}, weights{1.0}, count(1) {}
  explicit Lever(const PairMotion& pair) : nodes(pair.nodes), weights(pair.weights), count(pair.count) {}

  // use(node, weight)
  template <class Use>
  void for_each(const Use& use) const {
    for (std::size_t i = 0; i < count; ++i) use(nodes[i], weights[i]);
  }

  std::array<std::uint32_t, 4> nodes;
  std::array<double, 4> weights;
  std::size_t count;
};
// How these answer impulses on each other, 1/kg: three rows and columns each. clusters: of their nodes.
[[nodiscard]] Eigen::MatrixXd mobility_of(const Model& model, const std::vector<Lever>& levers,
                                          const StruckClusters& clusters);

// The direction of friction's slip of a pair that slides, unit: that of its velocity, or the kept one while it has
// hardly any; zero if there is none.
[[nodiscard]] Vector3 slip_direction(const Model& model, const PairTouch& touch, const PairMotion& motion);

}  // namespace springnet
