// What the parts of a sweep know of a node in contact.
#pragma once

#include <Eigen/LU>

#include "constraints/contact.hpp"

namespace springnet {

[[nodiscard]] inline double theta_of(const springnet_sweep& sweep) { return sweep.theta > 0.0 ? sweep.theta : 1.0; }

// What an update made of a node, as if there were no surface.
struct Contact::Candidate {
  std::uint32_t node;
  Vector3 start, start_velocity;  // m, m/s, at the beginning of the step
  Vector3 position, velocity;     // m, m/s
  Matrix3 inertia, mobility;      // kg, 1/kg
  Vector3 read;                   // m/s: what the update started from

  // The same update as if the node were as inert in every direction as in its most inert one: the fixed point stays,
  // and friction always finds a direction.
  [[nodiscard]] Candidate isotropic() const {
    Candidate result = *this;
    const double most = inertia.norm();
    result.velocity = read + inertia * (velocity - read) / most;
    result.inertia = most * Matrix3::Identity();
    result.mobility = Matrix3::Identity() / most;
    return result;
  }
  [[nodiscard]] bool is_isotropic() const { return inertia == Matrix3(inertia(0, 0) * Matrix3::Identity()); }
};

// Where surfaces let a node go.
struct Contact::Slide {
  Touch touch;
  double normal;               // N s, the least of the surfaces; < 0 where one would have to pull
  std::int32_t weakest;        // the surface of that
  Vector3 impulse;             // N s
  Vector3 position, velocity;  // m, m/s, at the end
  Vector3 slip;                // m/s, against the surface
  bool bounces = false;
};

struct Contact::Within {
  const springnet_sweep& sweep;
  const Placement& at;
};

}  // namespace springnet
