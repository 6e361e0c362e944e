// Contact of one node with two surfaces where they meet: it slides along their edge, or friction stops it.
#pragma once

#include <Eigen/Core>

#include <springnet/network.hpp>

namespace springnet {

struct EdgeResponse {
  Vector3 velocity;      // m/s, relative to the edge, after the impulse
  Vector3 impulse;       // N s, on the node
  double first, second;  // N s, normal impulses; < 0: the surface would have to pull
  bool sticks;           // the surfaces carry the node
  bool fits = true;      // false: no slip direction fits, so the node was stopped
};

// As solve_contact, for surfaces with unit normals `first` and `second` and these coefficients of friction, which may
// be infinite. The velocities along both normals become zero whatever the signs of the impulses. Friction of both adds
// up along the edge. Surfaces that are flush have no edge: they stop the node. `kept`, unless null: the node slips,
// with the sign of this direction.
[[nodiscard]] EdgeResponse solve_edge(const Eigen::Matrix3d& mobility, const Vector3& relative, const Vector3& first,
                                      const Vector3& second, double first_friction, double second_friction,
                                      const Vector3* kept = nullptr);

}  // namespace springnet
