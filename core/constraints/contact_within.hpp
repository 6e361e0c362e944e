// Types shared by the parts of contact within a sweep.
#pragma once

#include <Eigen/LU>

#include "constraints/contact.hpp"

namespace springnet {

[[nodiscard]] inline double theta_of(const springnet_sweep& sweep) { return sweep.theta > 0.0 ? sweep.theta : 1.0; }

// A node's outputs by the update rule, before contact.
struct Contact::Candidate {
  std::uint32_t node;
  Vector3 start, start_velocity;  // m, m/s, at the start of the step
  Vector3 position, velocity;     // m, m/s
  Matrix3 inertia;                // kg
  Vector3 read;                   // m/s: the velocity that the update started from

  // The same update with the isotropic inertia |inertia| I: the fixed point is the same, and a slip direction always
  // exists.
  [[nodiscard]] Candidate isotropic() const {
    Candidate result = *this;
    const double most = inertia.norm();
    result.velocity = read + inertia * (velocity - read) / most;
    result.inertia = most * Matrix3::Identity();
    return result;
  }
  [[nodiscard]] bool is_isotropic() const { return inertia == Matrix3(inertia(0, 0) * Matrix3::Identity()); }
  // 1/kg.
  [[nodiscard]] Matrix3 mobility() const { return inertia.inverse(); }
};

// A node constrained to the surfaces that it touches.
struct Contact::Slide {
  Touch touch;
  double normal;               // N s, smallest normal impulse; < 0: that surface would have to pull
  std::int32_t weakest;        // the surface with this impulse
  Vector3 impulse;             // N s
  Vector3 position, velocity;  // m, m/s, at the end of the step
  Vector3 slip;                // m/s, relative to the surface
  bool bounces = false;
  bool lands = false;  // its velocity becomes `landing`, m/s, at the commit
  Vector3 landing = Vector3::Zero();
  Vector3 landing_impulse = Vector3::Zero();  // N s
};

struct Contact::Within {
  const springnet_sweep& sweep;
  const Placement& at;
};

}  // namespace springnet
