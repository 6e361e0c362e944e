// What one spring contributes to the derivatives of the forces on its ends.
#pragma once

#include <cmath>

#include "layers/block.hpp"
#include "layers/law_pair.hpp"

namespace springnet::layers {

// Forces of a spring's laws and their derivatives: sums over its axial laws, and over those along the relative
// velocity.
struct SpringForces {
  double tension = 0.0;    // T, N, axial
  double by_length = 0.0;  // dT/dl, N/m
  double by_rate = 0.0;    // dT/du, N s/m
  double pull = 0.0;       // Q, N, along the relative velocity
  double by_speed = 0.0;   // dQ/d|dv|, N s/m

  void add(const Law& law, double force, double by_q, double by_u) noexcept {
    if (law.relative) {
      pull += force;
      by_speed += by_q;
    } else {
      tension += force;
      by_length += by_q;
      by_rate += by_u;
    }
  }
  [[nodiscard]] bool is_finite() const noexcept {
    return std::isfinite(tension + by_length + by_rate + pull + by_speed);
  }
};

// Of member i of a batch of springs, from what its laws answered with derivatives.
template <std::size_t capacity>
[[nodiscard]] SpringForces spring_forces(const Group& group, const PairAnswers<capacity>& answers, std::size_t i) {
  SpringForces sum;
  const std::array<const Law*, 2> laws = group.laws();
  for (std::size_t k = 0; k < laws.size(); ++k)
    if (*laws[k]) sum.add(*laws[k], answers.force[k][i], answers.by_q[k][i], answers.by_rate[k][i]);
  return sum;
}

// With dp, dv the relative position and velocity of a spring's ends, F the force on its first end:
//   K = -dF/d(dp) = T' n n^T + (T / l)(I - n n^T) + T_u n w^T,   w = (dv - u n) / l
//   D = -dF/d(dv) = T_u n n^T + Q' s s^T + (Q / |dv|)(I - s s^T)
// (T, T', T_u: axial tension and its derivatives with respect to length and rate; Q, Q': force along the relative
// velocity, direction s, and its derivative). Both are the same seen from either end. K is not symmetric where the
// viscosity is axial.

// T / l and w of the axial part.
struct AxialTerms {
  double tension_over_length = 0.0;  // N/m; 0 where the ends coincide
  Vector3 across = Vector3::Zero();  // 1/s

  AxialTerms(double tension_over, const Vector3& w) : tension_over_length(tension_over), across(w) {}
  // normal, along: n and s, zero where the ends coincide or move alike; length m, rate and speed m/s.
  AxialTerms(const SpringForces& forces, double length, const Vector3& normal, double rate, double speed,
             const Vector3& along) {
    if (!(length > 0.0)) return;
    tension_over_length = forces.tension / length;
    across = (speed * along - rate * normal) / length;
  }
};

struct SpringBlocks {
  Block stiffness;  // K, N/m
  Block damping;    // D, N s/m

  // As AxialTerms.
  SpringBlocks(const SpringForces& forces, double length, const Vector3& normal, double rate, double speed,
               const Vector3& along)
      : damping(Block::Zero()) {
    if (speed > 0.0)
      damping = forces.by_speed * along * along.transpose() +
                (forces.pull / speed) * (Block::Identity() - along * along.transpose());
    else
      damping = forces.by_speed * Block::Identity();
    add_axial({forces, length, normal, rate, speed, along}, forces.by_length, forces.by_rate, normal);
  }
  // Of a spring whose laws are axial.
  SpringBlocks(const AxialTerms& terms, double by_length, double by_rate, const Vector3& normal)
      : damping(Block::Zero()) {
    add_axial(terms, by_length, by_rate, normal);
  }

 private:
  void add_axial(const AxialTerms& terms, double by_length, double by_rate, const Vector3& normal) {
    const Block projector = normal * normal.transpose();
    damping += by_rate * projector;
    stiffness = by_length * projector;
    stiffness += terms.tension_over_length * (Block::Identity() - projector);
    stiffness += by_rate * normal * terms.across.transpose();
  }
};

}  // namespace springnet::layers
