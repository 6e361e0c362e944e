// Contact of one node with one surface: no penetration, no pull, friction.
#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>

#include <springnet/network.hpp>

namespace springnet {

// Friction coefficient that stands for a holding surface, for nodes with rigid connections. There a contact whose
// normal force vanishes can neither hold (it would pull) nor open (the remaining forces press it in again). It slides,
// with zero normal force and a finite tangential force: the limit of great friction.
inline constexpr double friction_of_held = 1e4;
[[nodiscard]] Friction bounded(const Friction& friction) noexcept;

// A surface's coefficient of friction, 1; infinite for a holding surface.
[[nodiscard]] double coefficient_of(const Friction& friction) noexcept;
// The same for a sliding node: finite.
[[nodiscard]] double sliding_coefficient_of(const Friction& friction) noexcept;
// Greatest tangential force of friction for a normal force, both in N; infinite for a holding surface.
[[nodiscard]] double friction_limit(double coefficient, double normal_force) noexcept;
// Margin of a force (N) to the boundary of the friction cone, N; < 0 outside of it. Every test of Coulomb's cone uses
// this function.
[[nodiscard]] double cone_margin(double coefficient, double normal_force, double tangential_force) noexcept;
// Derivative with respect to the node's velocity, N s/m, of the force -strength t(v), N; t is the direction of the slip
// v (m/s) on a surface with normal n.
[[nodiscard]] Eigen::Matrix3d friction_by_velocity(double strength, const Vector3& slip, const Vector3& n);

// The tangential direction at which `residual` vanishes, on a surface with normal n (unit), by the secant method from
// `start` (unit, tangential); empty if it does not converge.
[[nodiscard]] std::optional<Vector3> find_direction(const Vector3& n, const Vector3& start,
                                                    const std::function<double(const Vector3&)>& residual);

struct ContactResponse {
  Vector3 velocity;  // m/s, relative to the surface, after the impulse
  Vector3 impulse;   // N s, on the node
  double normal;     // N s; < 0: the surface would have to pull
  bool sticks;       // the surface carries the node
};

// The contact impulse on a node with velocity `relative` (m/s) to the surface without it, and `mobility` (1/kg,
// symmetric positive definite). n: unit normal to the free side. The velocity along n becomes zero whatever the sign of
// the impulse; the caller decides what a negative one means. Implicit Coulomb friction: the node sticks if an impulse
// within the friction cone can stop it, else friction opposes the remaining slip. more: N s, along n, of which friction
// is, too, but not the velocity.
[[nodiscard]] ContactResponse solve_contact(const Eigen::Matrix3d& mobility, const Vector3& relative, const Vector3& n,
                                            const Friction& friction, double more = 0.0);

// Replaces `held` friction by this coefficient.
[[nodiscard]] inline Friction capped(const Friction& friction, double coefficient) {
  return friction.kind == Friction::Kind::held ? Friction{Friction::Kind::coulomb, coefficient} : friction;
}

}  // namespace springnet
