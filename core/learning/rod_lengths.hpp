// Rigid connections within a cluster, and surfaces that its nodes lie on.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include <springnet/network.hpp>

namespace springnet::learning {

struct ClusterRod {
  Eigen::Index first, second;  // places in the cluster
  double length;               // m
};

// A node of the cluster that lies on a surface.
struct ClusterGap {
  Eigen::Index node;
  std::function<double(const Vector3& place)> gap;      // m
  std::function<Vector3(const Vector3& place)> normal;  // its gradient
};

// The nearest positions ([3 node], m) with the rods' lengths, and with nodes on their surfaces. Nodes without mobility
// ([node], 1/kg) stay where they are; all others move, those too that stick to a surface: with other lengths no step
// would begin.
[[nodiscard]] Eigen::VectorXd with_lengths(const std::vector<ClusterRod>& rods, const Eigen::VectorXd& mobility,
                                           Eigen::VectorXd place, const std::vector<ClusterGap>& on = {});

}  // namespace springnet::learning
