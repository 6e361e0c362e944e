// Rotations by the SDK's sine and cosine: those of the C library differ between processors in the last bit.
#pragma once

#include <springnet/network.hpp>
#include <springnet/sdk/math.hpp>

namespace springnet {

// By an angle, rad, about an axis of length 1 (Rodrigues).
[[nodiscard]] inline Eigen::Matrix3d rotation_about(const Vector3& axis, double angle) {
  const double sine = sdk::sin(angle), cosine = sdk::cos(angle);
  Eigen::Matrix3d cross;
  cross << 0.0, -axis[2], axis[1], axis[2], 0.0, -axis[0], -axis[1], axis[0], 0.0;
  return cosine * Eigen::Matrix3d::Identity() + sine * cross + (1.0 - cosine) * (axis * axis.transpose());
}

}  // namespace springnet
