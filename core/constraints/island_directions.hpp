// Directions in which a node in contact can move.
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "constraints/island.hpp"

namespace springnet {

// The directions in which a node with these normals can slide: two, one (along an edge) or none.
inline std::vector<Vector3> free_directions(const std::vector<Vector3>& normals) {
  if (normals.size() == 1) {
    const Vector3 e = normals[0].unitOrthogonal();
    return {e, normals[0].cross(e)};
  }
  if (normals.size() == 2) {
    const Vector3 e = normals[0].cross(normals[1]);
    if (e.norm() > 1e-12) return {e.normalized()};
  }
  return {};
}

inline std::vector<Vector3> normals_of(const ContactNode& node) {
  std::vector<Vector3> normals;
  for (const ContactSide& side : node.sides) normals.push_back(side.normal);
  return normals;
}

// What of a vector lies in the directions in which a node can slide.
inline Vector3 along(const std::vector<Vector3>& directions, const Vector3& v) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& e : directions) sum += e * e.dot(v);
  return sum;
}

}  // namespace springnet
