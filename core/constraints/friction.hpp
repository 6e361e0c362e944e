// What a surface does to one node in contact: no penetration, no pull, friction.
#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>

#include <springnet/network.hpp>

namespace springnet {

// Of a surface that holds what touches it, for nodes with rigid connections. There a contact whose normal force
// vanishes can neither hold, because it would pull, nor let go, because what is left of the other forces presses it in
// again: it slides, with no normal force and a force along the surface, which is the limit of great friction.
inline constexpr double friction_of_held = 1e4;
[[nodiscard]] Friction bounded(const Friction& friction) noexcept;

// The coefficient of a surface's friction, 1; infinite where it holds what touches it.
[[nodiscard]] double coefficient_of(const Friction& friction) noexcept;
// The same of a node that slides.
[[nodiscard]] double sliding_coefficient_of(const Friction& friction) noexcept;
// The most force along a surface that friction bears, N, where this presses on it, N: without bounds where it holds.
[[nodiscard]] double bearing(double coefficient, double pressing) noexcept;
// How much more force along a surface friction could bear, N; < 0 where it cannot bear what there is. This is Coulomb's
// cone, wherever it is asked for.
[[nodiscard]] double grip(double coefficient, double pressing, double along) noexcept;
// The derivative of the force -strength t(v), N, with t the direction of the slip v (m/s) on a surface with normal n,
// by the node's velocity; N s/m.
[[nodiscard]] Eigen::Matrix3d friction_by_velocity(double strength, const Vector3& slip, const Vector3& n);

// The direction along a surface with normal n (unit) at which `turn` vanishes, by the secant method from `start` (unit,
// along the surface); empty where that leads to none.
[[nodiscard]] std::optional<Vector3> find_direction(const Vector3& n, const Vector3& start,
                                                    const std::function<double(const Vector3&)>& turn);

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
