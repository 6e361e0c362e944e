#include "learning/observed_surface.hpp"

#include <algorithm>
#include <cmath>

#include "learning/outlier.hpp"

namespace springnet::learning {

using Eigen::MatrixXd;
using Eigen::VectorXd;

ObservedSurface::ObservedSurface(Surface& surface, const Observations& observations,
                                 const std::vector<double>& state_times)
    : surface_(surface), outlier_distance_(observations.outlier_distance), first_(state_times.size() + 1, 0) {
  for (const Observations::SurfacePoint& each : observations.surface_points)
    if (each.weight > 0.0)
      rows_.push_back({each.time, between_states(state_times, each.time, false), each.point, std::sqrt(each.weight)});
  std::stable_sort(rows_.begin(), rows_.end(), [](const Row& a, const Row& b) { return a.time < b.time; });
  for (const Row& row : rows_) ++first_[row.at.state + 1];
  for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
}

void ObservedSurface::residuals(const MotionDerivatives& motion, Eigen::Ref<VectorXd> out) {
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    Row& row = rows_[k];
    if (k == 0 || row.time != rows_[k - 1].time) surface_.move(vectors_at(motion, row.at));
    row.nearest = surface_.nearest(row.observed);
    const Vector3 way = row.nearest.point - row.observed;
    auto residual = out.segment<3>(3 * static_cast<Eigen::Index>(k));
    residual = row.root_weight * way;
    row.by_point = row.root_weight * row.nearest.normal;
    if (!(way.norm() > outlier_distance_)) continue;
    // The way is normal to the surface, so the plane of the surface lies across it.
    const Outlier outlier(way, outlier_distance_);
    residual *= outlier.share;
    row.by_point = row.root_weight *
                   (outlier.share * row.nearest.normal + outlier.by_way - outlier.share * Eigen::Matrix3d::Identity());
  }
}

template <class What>
void ObservedSurface::for_each_beside(std::size_t state, const What& what) const {
  for (std::size_t end = 0; end < 2; ++end) {
    if (end > state || state - end + 1 >= first_.size()) continue;
    for (std::size_t k = first_[state - end]; k < first_[state - end + 1]; ++k)
      what(rows_[k], 3 * static_cast<Eigen::Index>(k), end);
  }
}

void ObservedSurface::add_tangent(std::size_t state, const MatrixXd& positions, const MatrixXd& velocities,
                                  Eigen::Ref<MatrixXd> out) const {
  for_each_beside(state, [&](const Row& row, Eigen::Index first, std::size_t end) {
    const double a = row.at.p[end], b = row.at.v[end];
    if (a == 0.0 && b == 0.0) return;
    MatrixXd change = MatrixXd::Zero(3, positions.cols());
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double share = row.nearest.weights[i];
      if (share == 0.0) continue;
      const auto node = 3 * Eigen::Index{row.nearest.nodes[static_cast<std::size_t>(i)]};
      change += share * a * positions.middleRows<3>(node) + share * b * velocities.middleRows<3>(node);
    }
    out.middleRows<3>(first) += row.by_point * change;
  });
}

void ObservedSurface::add_adjoint(std::size_t state, const Eigen::Ref<const VectorXd>& weights,
                                  MotionDerivatives::StateChange& to) const {
  for_each_beside(state, [&](const Row& row, Eigen::Index first, std::size_t end) {
    const Vector3 by_point = row.by_point * weights.segment<3>(first);  // which is symmetric
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto node = row.nearest.nodes[static_cast<std::size_t>(i)];
      to.positions.col(node) += row.at.p[end] * row.nearest.weights[i] * by_point;
      to.velocities.col(node) += row.at.v[end] * row.nearest.weights[i] * by_point;
    }
  });
}

}  // namespace springnet::learning
