#include "learning/rod_lengths.hpp"

#include <limits>
#include <utility>

#include "constraints/least_squares.hpp"
#include "constraints/vectors.hpp"

namespace springnet::learning {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd with_lengths(const std::vector<ClusterRod>& rods, const VectorXd& mobility, VectorXd place,
                      const std::vector<ClusterGap>& on) {
  const auto lengths = static_cast<Index>(rods.size()), count = lengths + static_cast<Index>(on.size());
  constexpr int most = 10;
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most; ++i) {
    MatrixXd rows = MatrixXd::Zero(count, place.size());
    VectorXd gap(count);
    for (Index r = 0; r < lengths; ++r) {
      const ClusterRod& rod = rods[static_cast<std::size_t>(r)];
      const Vector3 way = place.segment<3>(3 * rod.first) - place.segment<3>(3 * rod.second);
      gap[r] = way.norm() - rod.length;
      for (const auto& [node, sign] : {std::pair(rod.first, 1.0), std::pair(rod.second, -1.0)})
        if (mobility[node] > 0.0) rows.block<1, 3>(r, 3 * node) = sign * way.normalized().transpose();
    }
    for (Index r = lengths; r < count; ++r) {
      const ClusterGap& own = on[static_cast<std::size_t>(r - lengths)];
      const Vector3 at = place.segment<3>(3 * own.node);
      gap[r] = own.gap(at);
      rows.block<1, 3>(r, 3 * own.node) = own.normal(at).transpose();
    }
    const double worst = gap.cwiseAbs().maxCoeff();
    if (worst >= 0.5 * last) break;  // only rounding is left
    last = worst;
    place -= least_squares(rows, gap);
  }
  return place;
}

}  // namespace springnet::learning
