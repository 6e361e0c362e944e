// Rigid connections in a straight step: impulses along the directions at its start keep the lengths at its end.

#include <algorithm>
#include <cmath>
#include <limits>

#include "constraints/rigid.hpp"

namespace springnet {

bool RigidConnections::WithoutContact::keep_lengths(double h, std::vector<Vector3>& velocity,
                                                    std::vector<Vector3>& position) const {
  constexpr int max_iterations = 60;
  constexpr double accuracy = 1e-13;  // of a length
  const std::vector<ConstraintRow>& rows = system_.rows();
  Eigen::VectorXd gap(static_cast<Eigen::Index>(rows.size()));
  double last = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    double worst = 0.0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const double length = rigid_.rods_[rods_[r]].length;
      const Vector3 d = position[rigid_.member_of_[rows[r].first]] - position[rigid_.member_of_[rows[r].second]];
      gap[static_cast<Eigen::Index>(r)] = d.norm() - length;
      worst = std::max(worst, std::abs(d.norm() / length - 1.0));
    }
    if (!std::isfinite(worst)) return false;
    // Far from the origin only rounding is left.
    if (worst <= accuracy || (worst <= 1e-10 && worst >= 0.5 * last)) return true;
    last = worst;
    system_.for_each_change(system_.solve(-gap / h), [&](std::uint32_t node, const Vector3& change) {
      velocity[rigid_.member_of_[node]] += change;
      position[rigid_.member_of_[node]] += h * change;
    });
  }
  return last <= 1e-9;
}

void RigidConnections::WithoutContact::project(std::vector<Vector3>& velocity) const {
  const auto of = [&](std::uint32_t node) -> const Vector3& { return velocity[rigid_.member_of_[node]]; };
  system_.for_each_change(system_.solve(-system_.rates(of)), [&](std::uint32_t node, const Vector3& change) {
    velocity[rigid_.member_of_[node]] += change;
  });
}

}  // namespace springnet
