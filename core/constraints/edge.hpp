// What two surfaces do to one node where they meet: it slides along both, or their friction stops it.
#pragma once

#include <Eigen/Core>

#include <springnet/network.hpp>

namespace springnet {

struct EdgeAnswer {
  Vector3 velocity;      // m/s, relative to the edge, after it
  Vector3 impulse;       // N s, on the node
  double first, second;  // N s, normal impulses; < 0 where a surface would have to pull
  bool sticks;           // the surfaces take the node along
  bool fits = true;      // friction has a direction; else the node was stopped for want of one
};

// As answer_contact, between surfaces with unit normals `first` and `second` and these coefficients of friction, which
// may be infinite. The velocity along both normals becomes zero whatever the signs of the impulses for that. Friction
// sums up along the edge. Surfaces that lie against each other have no edge: they stop the node.
// `kept`, unless null: a direction in which the node slips, come what may.
[[nodiscard]] EdgeAnswer answer_edge(const Eigen::Matrix3d& mobility, const Vector3& relative, const Vector3& first,
                                     const Vector3& second, double first_friction, double second_friction,
                                     const Vector3* kept = nullptr);

}  // namespace springnet
