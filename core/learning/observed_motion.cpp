#include "learning/observed_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet::learning {

namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// States and observations at the same time differ by the rounding of their sums.
constexpr double same_time = 1e-9;  // of a step

// Cubic Hermite polynomials at a share s of a step of length h: of x, h x', x and h x' of its ends.
void set_weights(double s, double h, bool rate, double (&p)[2], double (&v)[2]) {
  if (rate) {
    p[0] = 6.0 * s * (s - 1.0) / h;
    p[1] = -p[0];
    v[0] = (1.0 - s) * (1.0 - 3.0 * s);
    v[1] = s * (3.0 * s - 2.0);
    return;
  }
  p[0] = (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s);
  p[1] = s * s * (3.0 - 2.0 * s);
  v[0] = h * s * (1.0 - s) * (1.0 - s);
  v[1] = h * s * s * (s - 1.0);
}

void refuse(std::size_t rows, const char* what) {
  if (rows > 0)
    throw Error(
        ErrorKind::input,
        fmt::format("learning: observations of {} are not learned from; give positions, velocities or distances "
                    "of nodes",
                    what));
}

}  // namespace

ObservedMotion::ObservedMotion(const Observations& observations, const std::vector<double>& state_times) {
  refuse(observations.reactions.size(), "reaction forces");
  refuse(observations.surface_points.size(), "points on the surface");
  of_state_.resize(state_times.size());
  const auto between = [&](double time, bool rate) {
    const auto after = std::upper_bound(state_times.begin(), state_times.end(), time);
    const auto last = static_cast<std::ptrdiff_t>(state_times.size()) - 2;
    Between at;
    at.state = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - state_times.begin() - 1, 0, last));
    const double h = state_times[at.state + 1] - state_times[at.state];
    double share = (time - state_times[at.state]) / h;
    if (std::abs(share - std::round(share)) <= same_time) share = std::round(share);
    set_weights(share, h, rate, at.p, at.v);
    return at;
  };
  for (const bool rate : {false, true})
    for (const Observations::VectorRow& each : rate ? observations.velocities : observations.positions)
      add({false, each.node, each.node, between(each.time, rate), each.value, each.weight.cwiseSqrt(), {}, 0});
  for (const Observations::DistanceRow& each : observations.distances)
    add({true, each.node, each.other, between(each.time, false), Vector3(each.distance, 0, 0),
         Vector3(std::sqrt(each.weight), 0, 0), Vector3::Zero(), 0});
}

void ObservedMotion::add(const Row& row) {
  if (row.root_weight.isZero(0.0)) return;
  of_state_[row.at.state].push_back(rows_.size());
  rows_.push_back(row);
  rows_.back().first = count_;
  count_ += row.is_distance ? 1 : 3;
}

void ObservedMotion::residuals(const MotionDerivatives& motion, Eigen::Ref<VectorXd> out) {
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
        out.segment<3>(row.first) = row.root_weight.cwiseProduct(vector_of(row.node) - row.observed);
        continue;
      }
      const Vector3 way = vector_of(row.node) - vector_of(row.other);
      const double distance = way.norm();
      row.direction = distance > 0.0 ? Vector3(way / distance) : Vector3::Zero();
      out[row.first] = row.root_weight[0] * (distance - row.observed[0]);
    }
  }
}

void ObservedMotion::add_tangent(std::size_t state, const MatrixXd& positions, const MatrixXd& velocities,
                                 Eigen::Ref<MatrixXd> out) const {
  for (std::size_t end = 0; end < 2; ++end) {  // of the step: the state is its start, or its end
    if (end > state || state - end >= of_state_.size()) continue;
    for (const std::size_t number : of_state_[state - end]) {
      const Row& row = rows_[number];
      const double a = row.at.p[end], b = row.at.v[end];
      if (a == 0.0 && b == 0.0) continue;
      const auto of = [&](NodeIndex node) -> MatrixXd {
        return a * positions.middleRows<3>(3 * Eigen::Index{node}) +
               b * velocities.middleRows<3>(3 * Eigen::Index{node});
      };
      if (row.is_distance)
        out.row(row.first) += row.root_weight[0] * row.direction.transpose() * (of(row.node) - of(row.other));
      else
        out.middleRows<3>(row.first) += row.root_weight.asDiagonal() * of(row.node);
    }
  }
}

void ObservedMotion::add_adjoint(std::size_t state, const Eigen::Ref<const VectorXd>& weights,
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
        add(row.node, row.root_weight.cwiseProduct(weights.segment<3>(row.first)));
        continue;
      }
      const Vector3 along = row.root_weight[0] * weights[row.first] * row.direction;
      add(row.node, along);
      add(row.other, -along);
    }
  }
}

}  // namespace springnet::learning
