#include "constraints/acceleration_gradients.hpp"

#include <Eigen/Geometry>

namespace springnet {
namespace {

Matrix3 cross(const Vector3& w) {
  Matrix3 m;
  m << 0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0;
  return m;
}

// d(w' H w)/dp at fixed w, where the surface is part of a plane, a cylinder or a sphere: there H = (Q - n n') / r, with
// Q constant and dn/dp = H, so that it is -2 (n w) H w / r - (w' H w) n / r, and 1 / r is the norm of H.
Vector3 curvature_gradient(const Vector3& n, const Matrix3& h, const Vector3& w) {
  const Vector3 hw = h * w;
  const double trace = h.trace();
  if (!(trace != 0.0)) return Vector3::Zero();
  const double inverse_radius = h.squaredNorm() / trace;  // of equal eigenvalues, and zeros
  return -inverse_radius * (2.0 * n.dot(w) * hw + w.dot(hw) * n);
}

}  // namespace

Matrix3 velocity_by_position(const Pose& pose) { return pose.turns ? cross(pose.spin) : Matrix3(Matrix3::Zero()); }
Matrix3 acceleration_by_position(const Pose& pose) {
  if (!pose.turns) return Matrix3::Zero();
  const Matrix3 spin = cross(pose.spin);
  return cross(pose.spin_acceleration) + spin * spin;
}

// n (a - a_s) + w' H w - 2 n (spin x w), with w = v - v_s; see Obstacle::bias_acceleration.
AccelerationGradient gap_acceleration_gradient(const Contact& contact, const Placement& at, std::size_t surface,
                                               const Vector3& p, const Vector3& v, const Vector3& a) {
  const Pose& pose = at.poses[surface];
  const Vector3 n = contact.normal(at, surface, p), w = v - Contact::velocity(at, surface, p);
  const Matrix3 h = contact.obstacles()[surface].curvature(pose, p);
  const Matrix3 spin = velocity_by_position(pose);
  AccelerationGradient result;
  result.by_velocity = 2.0 * (h * w) - 2.0 * (spin.transpose() * n);
  result.by_position = h * (a - Contact::acceleration(at, surface, p)) -
                       acceleration_by_position(pose).transpose() * n + curvature_gradient(n, h, w) -
                       2.0 * (h * (spin * w)) - spin.transpose() * result.by_velocity;
  return result;
}

// n da + (|dv|^2 - (n dv)^2) / l.
AccelerationGradient length_acceleration_gradient(const Vector3& dp, const Vector3& dv, const Vector3& da) {
  const double l = dp.norm();
  const Vector3 n = dp / l;
  const Matrix3 h = (Matrix3::Identity() - n * n.transpose()) / l;
  return {h * da + curvature_gradient(n, h, dv), 2.0 * (h * dv)};
}

Matrix3 direction_by_position(const Vector3& n, const Matrix3& h, const Vector3& vector, const Matrix3& by_position) {
  const Vector3 tangential = vector - n * n.dot(vector);
  const double length = tangential.norm();
  if (!(length > 0.0)) return Matrix3::Zero();
  const Vector3 t = tangential / length;
  const Matrix3 change =
      by_position - n * n.transpose() * by_position - n.dot(vector) * h - n * (h * vector).transpose();
  return (Matrix3::Identity() - t * t.transpose()) * change / length;
}

}  // namespace springnet
