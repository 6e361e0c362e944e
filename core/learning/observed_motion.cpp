#include "learning/observed_motion.hpp"

#include <cmath>

#include "learning/outlier.hpp"

namespace springnet::learning {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ObservedMotion::ObservedMotion(const Observations& observations, const std::vector<double>& state_times,
                               ObservedNet& net)
    : outlier_distance_(observations.outlier_distance) {
  of_state_.resize(state_times.size());
  for (const bool rate : {false, true})
    for (const Observations::VectorRow& each : rate ? observations.velocities : observations.positions)
      add({false,
           each.node,
           each.node,
           between_states(state_times, each.time, rate),
           each.value,
           each.weight.cwiseSqrt(),
           {},
           0,
           !rate,
           {}});
  for (const Observations::DistanceRow& each : observations.distances)
    add({true,
         each.node,
         each.other,
         between_states(state_times, each.time, false),
         Vector3(each.distance, 0, 0),
         Vector3(std::sqrt(each.weight), 0, 0),
         Vector3::Zero(),
         0,
         false,
         {}});
  if (!observations.surface_points.empty()) surface_.emplace(net.surface(), observations, state_times);
  if (!observations.reactions.empty()) reactions_.emplace(net.reactions(), observations, state_times);
}

Eigen::Index ObservedMotion::count() const noexcept {
  return count_ + (surface_ ? surface_->count() : 0) + (reactions_ ? reactions_->count() : 0);
}

void ObservedMotion::add(const Row& row) {
  if (row.root_weight.isZero(0.0)) return;
  of_state_[row.at.state].push_back(rows_.size());
  rows_.push_back(row);
  rows_.back().first = count_;
  count_ += row.is_distance ? 1 : 3;
}

double ObservedMotion::extent(const Network& network) const {
  double square = 0.0;
  for (const Row& row : rows_) {
    const Vector3& own = network.nodes()[row.node].position;
    Vector3 start = (row.at.p[0] + row.at.p[1]) * own;  // 0 of velocities
    if (row.is_distance) start = Vector3((own - network.nodes()[row.other].position).norm(), 0, 0);
    for (Eigen::Index axis = 0; axis < 3; ++axis)  // what is missing has no weight, and is no number
      if (row.root_weight[axis] > 0.0)
        square += std::pow(row.root_weight[axis] * (row.observed[axis] - start[axis]), 2);
  }
  return std::sqrt(square);
}

void ObservedMotion::residuals(const MotionDerivatives& motion, const VectorXd& values, Eigen::Ref<VectorXd> out) {
  if (surface_) surface_->residuals(motion, out.segment(count_, surface_->count()));
  if (reactions_) reactions_->residuals(motion, values, out.tail(reactions_->count()));
  Matrix3Xd p[2], v[2];
  for (std::size_t k = 0; k + 1 < of_state_.size(); ++k) {
    if (of_state_[k].empty()) continue;
    for (std::size_t end = 0; end < 2; ++end) {
      p[end] = motion.positions(k + end);
      v[end] = motion.velocities(k + end);
    }
    for (const std::size_t number : of_state_[k]) {
      Row& row = rows_[number];
      const auto vector_of = [&](NodeIndex node) {
        return Vector3(row.at.p[0] * p[0].col(node) + row.at.v[0] * v[0].col(node) + row.at.p[1] * p[1].col(node) +
                       row.at.v[1] * v[1].col(node));
      };
      if (!row.is_distance) {
        set_residual(row, vector_of(row.node), out.segment<3>(row.first));
        continue;
      }
      const Vector3 way = vector_of(row.node) - vector_of(row.other);
      const double distance = way.norm();
      row.direction = distance > 0.0 ? Vector3(way / distance) : Vector3::Zero();
      out[row.first] = row.root_weight[0] * (distance - row.observed[0]);
    }
  }
}

void ObservedMotion::set_residual(Row& row, const Vector3& simulated, Eigen::Ref<VectorXd> out) const {
  Vector3 way = simulated - row.observed;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (row.root_weight[axis] == 0.0) way[axis] = 0.0;  // not observed
  out = row.root_weight.cwiseProduct(way);
  row.by_vector = row.root_weight.asDiagonal();
  if (!row.may_be_outlier || !(way.norm() > outlier_distance_)) return;
  const Outlier outlier(way, outlier_distance_);
  out *= outlier.share;
  row.by_vector = row.by_vector * outlier.by_way;
}

void ObservedMotion::add_tangent(const MotionDerivatives& motion, std::size_t state, const Tangents& changes,
                                 Eigen::Ref<MatrixXd> out) const {
  add_tangent_of_nodes(state, changes, out);
  if (surface_)
    surface_->add_tangent(state, changes.positions, changes.velocities, out.middleRows(count_, surface_->count()));
  if (reactions_)
    reactions_->add_tangent(motion, state, changes.values, changes.positions, changes.velocities,
                            out.bottomRows(reactions_->count()));
}

void ObservedMotion::add_adjoint(const MotionDerivatives& motion, std::size_t state,
                                 const Eigen::Ref<const VectorXd>& weights, MotionDerivatives::StateChange& to,
                                 VectorXd& by_values) const {
  add_adjoint_of_nodes(state, weights, to);
  if (surface_) surface_->add_adjoint(state, weights.segment(count_, surface_->count()), to);
  if (reactions_) reactions_->add_adjoint(motion, state, weights.tail(reactions_->count()), to, by_values);
}

void ObservedMotion::add_tangent_of_nodes(std::size_t state, const Tangents& changes, Eigen::Ref<MatrixXd> out) const {
  for (std::size_t end = 0; end < 2; ++end) {  // of the step: the state is its start, or its end
    if (end > state || state - end >= of_state_.size()) continue;
    for (const std::size_t number : of_state_[state - end]) {
      const Row& row = rows_[number];
      const double a = row.at.p[end], b = row.at.v[end];
      if (a == 0.0 && b == 0.0) continue;
      const auto of = [&](NodeIndex node) -> MatrixXd {
        return a * changes.positions.middleRows<3>(3 * Eigen::Index{node}) +
               b * changes.velocities.middleRows<3>(3 * Eigen::Index{node});
      };
      if (row.is_distance)
        out.row(row.first) += row.root_weight[0] * row.direction.transpose() * (of(row.node) - of(row.other));
      else
        out.middleRows<3>(row.first) += row.by_vector * of(row.node);
    }
  }
}

void ObservedMotion::add_adjoint_of_nodes(std::size_t state, const Eigen::Ref<const VectorXd>& weights,
                                          MotionDerivatives::StateChange& to) const {
  for (std::size_t end = 0; end < 2; ++end) {
    if (end > state || state - end >= of_state_.size()) continue;
    for (const std::size_t number : of_state_[state - end]) {
      const Row& row = rows_[number];
      const auto add = [&](NodeIndex node, const Vector3& by_vector) {
        to.positions.col(node) += row.at.p[end] * by_vector;
        to.velocities.col(node) += row.at.v[end] * by_vector;
      };
      if (!row.is_distance) {
        add(row.node, row.by_vector.transpose() * weights.segment<3>(row.first));
        continue;
      }
      const Vector3 along = row.root_weight[0] * weights[row.first] * row.direction;
      add(row.node, along);
      add(row.other, -along);
    }
  }
}

}  // namespace springnet::learning
