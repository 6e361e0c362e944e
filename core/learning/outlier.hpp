// Huber's function (P. J. Huber, Ann. Math. Statist. 35, 1964) as a residual: what is farther off than a distance
// counts by its distance in place of its square.
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace springnet::learning {

// Of a vector w that is longer than `most`, m: the residual f w has the half square most |w| - most^2 / 2.
struct Outlier {
  Outlier(const Eigen::Vector3d& way, double most) {
    const double distance = way.norm(), length = std::sqrt(2.0 * most * distance - most * most);
    const Eigen::Vector3d along = way / distance;
    share = length / distance;
    by_way = share * Eigen::Matrix3d::Identity() + (most / length - share) * along * along.transpose();
  }
  double share;            // f
  Eigen::Matrix3d by_way;  // derivative of f w, which is symmetric
};

}  // namespace springnet::learning
