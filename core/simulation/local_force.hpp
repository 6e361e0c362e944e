// The force on a grasped node or a surface, and its derivative by a translation of it over a step.
//
// Had a backward Euler step of length h taken the handle farther by d, the velocities at its end would differ by the u
// with
//
//   u = d / h                           on nodes that the handle carries,
//   G u = g                             g: the speed d / h along the normals of nodes that slide on it, else 0
//   M u = h (dF/dv u + dF/dp h u) + G^T (multipliers)      on all other nodes
//
// and the positions by h u. The force follows as the difference of the reactions in these directions.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "simulation/linear_model.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {

class LocalForceModel {
 public:
  // Friction follows the reactions by iterations of its own.
  explicit LocalForceModel(Model& model) : model_(model), linear_(model) { linear_.hold_friction(); }

  // At the committed state, over a step of `step` seconds. Throw Error(simulation).
  [[nodiscard]] Matrix3 stiffness_of_node(std::uint32_t node, double step);
  [[nodiscard]] Matrix3 stiffness_of_surface(std::size_t surface, double step);

 private:
  using Values = std::vector<double>;  // [3 node], by components
  struct Handle {
    std::uint32_t node = ConstraintRow::no_node;  // one of both
    std::int32_t surface = -1;
    [[nodiscard]] bool is_surface() const noexcept { return surface >= 0; }
  };
  struct Friction {  // of a node that slides on one surface
    std::uint32_t node;
    std::int32_t surface;
    double mass;
    Matrix3 by_velocity;  // N s/m, which the linear system has
    Vector3 normal;       // of the surface
    Vector3 share;        // friction over the pressing force
    // Its change by a velocity, besides that with the reaction at the end of the step: the impact over the step, too,
    // presses.
    [[nodiscard]] Vector3 without_reaction(const Vector3& velocity, double step) const {
      return mass / step * normal.dot(velocity) * share - by_velocity * velocity;
    }
  };

  Matrix3 stiffness(const Handle& handle, double step);
  void linearise(const Handle& handle);
  // Velocities that satisfy the constraints with the handle moving at `speed`, m/s.
  [[nodiscard]] Values carried(const Handle& handle, const Vector3& speed);
  [[nodiscard]] bool carries(const Handle& handle, std::uint32_t node) const;
  // The change of the force on the handle, N, if it moves at `speed` (m/s) over the step besides.
  struct Change {
    Vector3 force;
    Vector3 at_present_pressure;  // of surfaces on nodes with friction
    bool friction_follows;        // else `force` was not found
  };
  [[nodiscard]] Change change_along(const Handle& handle, double step, const Vector3& speed);
  // Of the linear system, from `carried` velocities, m/s.
  [[nodiscard]] Values right_side_of(double step, const Vector3& speed, const Values& carried);
  void add_force(Values& right_side, std::uint32_t node, const Vector3& force, double step) const;
  void add_solution(const Values& right_side, double wanted, double step, Values& velocity);
  // The derivatives by `velocity` (m/s) and positions that change by h times as much, of the force on the handle, N,
  // and of friction, [friction] N.
  [[nodiscard]] Vector3 change(const Handle& handle, double step, const Vector3& speed, const Values& velocity,
                               std::vector<Vector3>& friction);
  [[nodiscard]] double difference_along(const Handle& handle, const Vector3& speed, const Values& velocity) const;
  // Force of the network on the handle, and friction on the nodes, at a state.
  [[nodiscard]] Vector3 force(const Handle& handle, ReactionsAt& at, std::vector<Vector3>& friction) const;
  void check(springnet_status status) const;

  Model& model_;
  LinearModel linear_;
  using Parts = std::array<std::size_t, 3>;  // springs, elements and loaded faces that are left
  Parts parts_{};
  std::vector<Friction> friction_;
  std::vector<std::uint32_t> curved_;  // nodes that slide on the handle's surface
  std::vector<Matrix3> curvature_;     // [curved] N/m, pressing force times curvature
};

}  // namespace springnet
