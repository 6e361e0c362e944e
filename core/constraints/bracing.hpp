// Forces in rigid connections between sticking nodes are not unique. This finds the smallest that keep the nodes in
// place.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace springnet {

// The x of least norm with base + matrix x >= 0 in each row; empty if there is none.
[[nodiscard]] std::optional<Eigen::VectorXd> min_norm_nonnegative(const Eigen::VectorXd& base,
                                                                  const Eigen::MatrixXd& matrix);
// Friction cone of a sticking node. Its force is three rows of base + matrix x: the normal force and two tangential
// components, N.
struct Cone {
  double coefficient;       // of friction, 1
  double min_normal_force;  // N
};
// The x of least norm with which every force is in its cone; empty if there is none.
[[nodiscard]] std::optional<Eigen::VectorXd> min_norm_in_cones(const Eigen::VectorXd& base,
                                                               const Eigen::MatrixXd& matrix,
                                                               const std::vector<Cone>& cones);

}  // namespace springnet
