// How the constraints on accelerations, and the forces of their multipliers, change with positions and velocities: the
// second derivatives of gaps and lengths in time, with accelerations held, and the directions of friction.
#pragma once

#include <cstddef>

#include "constraints/contact.hpp"
#include "constraints/vectors.hpp"

namespace springnet {

struct AccelerationGradient {
  Vector3 by_position;  // 1/s^2
  Vector3 by_velocity;  // 1/s
};

// Of d^2 gap/dt^2 of a node at p (m) with velocity v (m/s) and acceleration a (m/s^2), held.
[[nodiscard]] AccelerationGradient gap_acceleration_gradient(const Contact& contact, const Placement& at,
                                                             std::size_t surface, const Vector3& p, const Vector3& v,
                                                             const Vector3& a);
// Of d^2 l/dt^2 of the distance l of two points, by the relative position dp and velocity dv; da: their relative
// acceleration, held.
[[nodiscard]] AccelerationGradient length_acceleration_gradient(const Vector3& dp, const Vector3& dv,
                                                                const Vector3& da);
// The derivative with respect to the position of the unit vector along the part of `vector` that is tangential to a
// surface with normal n and curvature h (1/m); by_position: that of the vector itself. 0 if there is no such part.
[[nodiscard]] Matrix3 direction_by_position(const Vector3& n, const Matrix3& h, const Vector3& vector,
                                            const Matrix3& by_position);
// Derivatives with respect to the position of the velocity and the acceleration of an obstacle, 1/s and 1/s^2.
[[nodiscard]] Matrix3 velocity_by_position(const Pose& pose);
[[nodiscard]] Matrix3 acceleration_by_position(const Pose& pose);

}  // namespace springnet
