// What a surface does to one node in contact: no penetration, no pull, friction.
#pragma once

#include <Eigen/Core>

#include <springnet/network.hpp>

namespace springnet {

struct ContactAnswer {
  Vector3 velocity;  // m/s, relative to the surface, after it
  Vector3 impulse;   // N s, on the node
  double normal;     // N s; < 0 where the surface would have to pull
  bool sticks;       // the surface takes the node along
};

// A node that would have the velocity `relative` (m/s) to the surface, and answers an impulse by `mobility` (1/kg,
// symmetric positive definite). n: unit normal to the free side. The velocity along n becomes zero whatever the sign of
// the impulse for that; what a negative one means is the caller's business. Implicit Coulomb friction: the node sticks
// where an impulse within the cone of friction can stop it, else friction acts against its remaining slip.
[[nodiscard]] ContactAnswer answer_contact(const Eigen::Matrix3d& mobility, const Vector3& relative, const Vector3& n,
                                           const Friction& friction);

}  // namespace springnet
