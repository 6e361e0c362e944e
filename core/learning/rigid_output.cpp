#include "learning/rigid_output.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/LU>

#include "constraints/least_squares.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

class Cluster {
 public:
  explicit Cluster(const ClusterOverStep& given)
      : given_(given), size_(given.p.size()), rods_(static_cast<Index>(given.rods.size())), weights_(size_) {
    for (Index k = 0; k < size_; ++k) weights_[k] = given.mobility[k / 3];
  }

  [[nodiscard]] std::optional<ClusterDerivative> derivative() const {
    // Velocities at the positions of the end.
    const Rows rows = rows_at(given_.P);
    const MatrixXd to_rods = rows.inverse * rows.g;  // S^-1 G
    const VectorXd x = -(to_rods * given_.free);
    const VectorXd ends = given_.free + weights_.cwiseProduct(rows.g.transpose() * x);
    const MatrixXd back = weights_.asDiagonal() * rows.g.transpose();
    const MatrixXd bends = weights_.asDiagonal() * stiffness(rows, x);
    const MatrixXd by_free = moving(MatrixXd(MatrixXd::Identity(size_, size_) - back * to_rods));
    const MatrixXd by_place = bends - back * (to_rods * bends + rows.inverse * turns(rows, ends));

    // Positions from those without connections.
    VectorXd place = given_.p + given_.c * given_.v + given_.w * ends;
    for (Index k = 0; k < size_; ++k)
      if (!(weights_[k] > 0.0)) place[k] = given_.P[k];
    const Corrected corrected = correct(place);
    constexpr double tolerance = 1e-4;
    const double speed = given_.v.norm() + given_.U.norm() + (given_.free - given_.v).norm();
    if (!((ends - given_.U).norm() <= tolerance * speed) ||
        !((place - given_.P).norm() <= tolerance * (given_.w + given_.c) * speed + 1e-9 * given_.P.norm()))
      return std::nullopt;

    // dU = by_free (dV + dW G^T x) + by_place dP, dP = by_start (dp + c dv + w dU) + by_mobility dW.
    const MatrixXd& by_start = corrected.by_start;
    const Eigen::PartialPivLU<MatrixXd> own(MatrixXd::Identity(size_, size_) - given_.w * by_place * by_start);
    const MatrixXd through = own.solve(by_place * by_start);
    MatrixXd result(2 * size_, 3 * size_);
    auto of_velocities = result.bottomRows(size_);
    of_velocities.leftCols(size_) = through;
    of_velocities.middleCols(size_, size_) = given_.c * through;
    of_velocities.rightCols(size_) = own.solve(by_free);
    result.topRows(size_) = given_.w * by_start * of_velocities;
    result.topLeftCorner(size_, size_) += by_start;
    result.block(0, size_, size_, size_) += given_.c * by_start;

    const Index nodes = size_ / 3;
    MatrixXd by_mobility(2 * size_, nodes);
    by_mobility.bottomRows(size_) =
        own.solve(by_free * of_mobility(rows.g.transpose() * x) + by_place * corrected.by_mobility);
    by_mobility.topRows(size_) = given_.w * by_start * by_mobility.bottomRows(size_) + corrected.by_mobility;
    const VectorXd by_length = result.leftCols(size_) * ((1.0 - given_.theta) * given_.v + given_.theta * ends);
    MatrixXd by_times(2 * size_, 2);
    by_times << -by_length, by_length;
    return ClusterDerivative{std::move(result), std::move(by_mobility), std::move(by_times)};
  }

 private:
  struct Rows {
    MatrixXd g;        // [rod][3 node]
    VectorXd lengths;  // m
    MatrixXd inverse;  // of G W G^T; of redundant rods the pseudoinverse
    std::vector<Vector3d> directions;
  };
  [[nodiscard]] Rows rows_at(const VectorXd& place) const {
    Rows result{MatrixXd::Zero(rods_, size_), VectorXd(rods_), {}, {}};
    for (Index r = 0; r < rods_; ++r) {
      const ClusterRod& rod = given_.rods[static_cast<std::size_t>(r)];
      const Vector3d way = place.segment<3>(3 * rod.first) - place.segment<3>(3 * rod.second);
      result.lengths[r] = way.norm();
      result.directions.emplace_back(way / way.norm());
      result.g.block<1, 3>(r, 3 * rod.first) = result.directions.back().transpose();
      result.g.block<1, 3>(r, 3 * rod.second) = -result.directions.back().transpose();
    }
    result.inverse = pseudo_inverse(result.g * weights_.asDiagonal() * result.g.transpose());
    return result;
  }
  // How a rod's direction turns with the difference of its ends.
  [[nodiscard]] static Matrix3d turn(const Rows& rows, Index r) {
    const Vector3d& d = rows.directions[static_cast<std::size_t>(r)];
    return (Matrix3d::Identity() - d * d.transpose()) / rows.lengths[r];
  }
  // d(G^T x) by positions, at constant x.
  [[nodiscard]] MatrixXd stiffness(const Rows& rows, const VectorXd& x) const {
    MatrixXd result = MatrixXd::Zero(size_, size_);
    for (Index r = 0; r < rods_; ++r) {
      const ClusterRod& rod = given_.rods[static_cast<std::size_t>(r)];
      const Matrix3d block = x[r] * turn(rows, r);
      result.block<3, 3>(3 * rod.first, 3 * rod.first) += block;
      result.block<3, 3>(3 * rod.second, 3 * rod.second) += block;
      result.block<3, 3>(3 * rod.first, 3 * rod.second) -= block;
      result.block<3, 3>(3 * rod.second, 3 * rod.first) -= block;
    }
    return result;
  }
  // d(G q) by positions, at constant q.
  [[nodiscard]] MatrixXd turns(const Rows& rows, const VectorXd& q) const {
    MatrixXd result = MatrixXd::Zero(rods_, size_);
    for (Index r = 0; r < rods_; ++r) {
      const ClusterRod& rod = given_.rods[static_cast<std::size_t>(r)];
      const Vector3d difference = q.segment<3>(3 * rod.first) - q.segment<3>(3 * rod.second);
      const Eigen::RowVector3d row = difference.transpose() * turn(rows, r);
      result.block<1, 3>(r, 3 * rod.first) += row;
      result.block<1, 3>(r, 3 * rod.second) -= row;
    }
    return result;
  }
  // dW times a vector of impulses, for a change of each mobility.
  [[nodiscard]] MatrixXd of_mobility(const VectorXd& impulses) const {
    MatrixXd result = MatrixXd::Zero(size_, size_ / 3);
    for (Index k = 0; k < size_; ++k)
      if (weights_[k] > 0.0) result(k, k / 3) = impulses[k];
    return result;
  }
  struct Corrected {
    MatrixXd by_start, by_mobility;  // of the positions at the end
  };
  // As RigidConnections::correct_positions: Newton's method, each step along the directions that it starts with.
  [[nodiscard]] Corrected correct(VectorXd& place) const {
    Corrected result{moving(MatrixXd::Identity(size_, size_)), MatrixXd::Zero(size_, size_ / 3)};
    constexpr int most = 30;
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i < most; ++i) {
      const Rows rows = rows_at(place);
      VectorXd gap(rods_);
      for (Index r = 0; r < rods_; ++r) gap[r] = rows.lengths[r] - given_.rods[static_cast<std::size_t>(r)].length;
      const double worst = gap.cwiseQuotient(rows.lengths).cwiseAbs().maxCoeff();
      if (worst >= 0.5 * last) break;  // only rounding is left
      last = worst;
      const VectorXd s = -(rows.inverse * gap), impulses = rows.g.transpose() * s;
      const VectorXd way = weights_.cwiseProduct(impulses);
      const MatrixXd back = weights_.asDiagonal() * rows.g.transpose() * rows.inverse;
      const MatrixXd bends = weights_.asDiagonal() * stiffness(rows, s);
      const MatrixXd change = bends - back * (rows.g + turns(rows, way) + rows.g * bends);
      const MatrixXd pushes = of_mobility(impulses);
      result.by_start += MatrixXd(change * result.by_start);
      result.by_mobility += MatrixXd(change * result.by_mobility + pushes - back * (rows.g * pushes));
      place += way;
    }
    return result;
  }
  // Nothing of nodes whose motion is given changes.
  [[nodiscard]] MatrixXd moving(MatrixXd matrix) const {
    for (Index k = 0; k < size_; ++k)
      if (!(weights_[k] > 0.0)) {
        matrix.row(k).setZero();
        matrix.col(k).setZero();
      }
    return matrix;
  }

  const ClusterOverStep& given_;
  Index size_, rods_;
  VectorXd weights_;  // [3 node] 1/kg
};

}  // namespace

std::optional<ClusterDerivative> output_derivative(const ClusterOverStep& cluster) {
  return Cluster(cluster).derivative();
}

}  // namespace springnet::learning
