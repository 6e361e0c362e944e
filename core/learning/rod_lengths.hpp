// Rigid connections within a cluster.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace springnet::learning {

struct ClusterRod {
  Eigen::Index first, second;  // places in the cluster
  double length;               // m
};

// The nearest positions ([3 node], m) with the rods' lengths. Nodes without mobility ([node], 1/kg) stay where they
// are; all others move, those too that stick to a surface: with other lengths no step would begin.
[[nodiscard]] Eigen::VectorXd with_lengths(const std::vector<ClusterRod>& rods, const Eigen::VectorXd& mobility,
                                           Eigen::VectorXd place);

}  // namespace springnet::learning
