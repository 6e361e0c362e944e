// Rigid connections between nodes that stick may bear any force. How much of it nodes need to stay where they are.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace springnet {

// The smallest x with base + matrix x >= 0 in each row; empty where there is none.
[[nodiscard]] std::optional<Eigen::VectorXd> least_with(const Eigen::VectorXd& base, const Eigen::MatrixXd& matrix);
// Of forces on nodes that stick, base + matrix x, three rows a node: normal force and two along the surface, N.
struct Cone {
  double coefficient;  // of friction, 1
  double least;        // N, of the normal force
};
// The smallest x with which friction bears them all; empty where there is none.
[[nodiscard]] std::optional<Eigen::VectorXd> least_in_cones(const Eigen::VectorXd& base, const Eigen::MatrixXd& matrix,
                                                            const std::vector<Cone>& cones);

}  // namespace springnet
