#include "layers/linear/node_response.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace springnet::layers {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Of singular values, the greatest of which is about 1: less is rounding of the directions of surfaces.
constexpr double least = 1e-6;
// Of C - C^T and E: more is friction, or a bounce.
constexpr double symmetric_to = 1e-12;

}  // namespace

void NodeResponses::set(const std::vector<NodeResponse>& responses) {
  nodes_.clear();
  symmetric_ = true;
  for (const NodeResponse& each : responses) {
    Own own;
    own.node = each.node;
    own.rank = 0;
    for (Matrix3d* matrix : {&own.t, &own.l, &own.right, &own.seen, &own.allowed}) matrix->setZero();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> parts(each.response.transpose() * each.response);
    for (Eigen::Index i = 2; i >= 0; --i) {  // ascending
      const Vector3d v = parts.eigenvectors().col(i), image = each.response * v;
      const double value = image.norm();
      if (!(value > least)) break;
      const Vector3d u = image / value;
      own.t.col(own.rank) = u;
      own.l.col(own.rank++) = value * v;
      own.right += v * u.transpose() / value;
      own.seen += v * v.transpose();
      own.allowed += u * u.transpose();
    }
    own.addition = own.right - own.seen * own.allowed;
    if (own.addition.norm() <= symmetric_to) own.addition.setZero();
    own.by_velocity = each.by_velocity;
    symmetric_ = symmetric_ && (each.response - each.response.transpose()).norm() <= symmetric_to &&
                 own.addition.isZero(0.0) && own.by_velocity.isZero(0.0);
    nodes_.push_back(own);
  }
}

std::optional<Matrix3d> NodeResponses::inverse_of(const Own& own, const Matrix3d& block) {
  if (own.rank == 0) return Matrix3d(Matrix3d::Zero());
  const auto t = own.t.leftCols(own.rank);
  const auto l = own.l.leftCols(own.rank);
  // Completed by ones, so that it has a fixed size.
  Matrix3d small = Matrix3d::Identity();
  small.topLeftCorner(own.rank, own.rank) = l.transpose() * block * t;
  const Eigen::FullPivLU<Matrix3d> factors(small);
  if (!factors.isInvertible()) return std::nullopt;
  const Matrix3d inverse = factors.inverse();
  const Matrix3d result = t * inverse.topLeftCorner(own.rank, own.rank) * l.transpose();
  if (!result.allFinite()) return std::nullopt;
  return result;
}

}  // namespace springnet::layers
