// What one spring contributes to the derivatives of the forces on its ends.
#pragma once

#include "layers/block.hpp"
#include "layers/laws.hpp"

namespace springnet::layers {

// Forces of a spring's laws and their derivatives, summed over the laws of each kind, from zero.
struct SpringForces {
  double tension;    // N, axial
  double by_length;  // N/m
  double by_rate;    // N s/m
  double pull;       // N, along the relative velocity
  double by_speed;   // N s/m

  // One law's answer; by_rate is null where the law does not read the rate.
  void add(const Law& law, double force, double by_q, const double* by_u) noexcept {
    if (law.relative) {
      pull += force;
      by_speed += by_q;
    } else {
      tension += force;
      by_length += by_q;
      if (law.reads_rate) by_rate += *by_u;
    }
  }
};

// With dp, dv the relative position and velocity of a spring's ends, F the force on its first end:
//   K = -dF/d(dp) = T' n n^T + (T / l)(I - n n^T) + T_u n w^T,   w = (dv - u n) / l
//   D = -dF/d(dv) = T_u n n^T + Q' s s^T + (Q / |dv|)(I - s s^T)
// (T, T', T_u: axial tension and its derivatives with respect to length and rate; Q, Q': force along the relative
// velocity, direction s, and its derivative). Both are the same seen from either end. K is not symmetric where the
// viscosity is axial.
struct SpringBlocks {
  Block stiffness;  // K, N/m
  Block damping;    // D, N s/m

  // normal, along: n and s, zero where the ends coincide or move alike; length m, rate and speed m/s.
  SpringBlocks(const SpringForces& forces, double length, const Vector3& normal, double rate, double speed,
               const Vector3& along)
      : damping(Block::Zero()) {
    if (speed > 0.0)
      damping = forces.by_speed * along * along.transpose() +
                (forces.pull / speed) * (Block::Identity() - along * along.transpose());
    else
      damping = forces.by_speed * Block::Identity();
    const Block projector = normal * normal.transpose();
    damping += forces.by_rate * projector;
    stiffness = forces.by_length * projector;
    if (length > 0.0) {
      stiffness += (forces.tension / length) * (Block::Identity() - projector);
      const Vector3 across = (speed * along - rate * normal) / length;
      stiffness += forces.by_rate * normal * across.transpose();
    }
  }
};

}  // namespace springnet::layers
