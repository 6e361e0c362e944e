// Directions in which a node in contact can move.
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "constraints/friction.hpp"
#include "constraints/island.hpp"

namespace springnet {

// The directions in which a node with these normals can slide: two, one (along an edge) or none. Parallel normals count
// as one, coplanar ones as two.
inline std::vector<Vector3> free_directions(const std::vector<Vector3>& normals) {
  if (normals.empty()) return {};
  constexpr double flush = 1e-12;
  Vector3 edge = Vector3::Zero();
  for (const Vector3& n : normals) {
    if (edge.isZero(0.0)) {
      const Vector3 e = normals[0].cross(n);
      if (e.norm() > flush) edge = e.normalized();
    } else if (std::abs(edge.dot(n)) > flush) {
      return {};
    }
  }
  if (!edge.isZero(0.0)) return {edge};
  const Vector3 e = normals[0].unitOrthogonal();
  return {e, normals[0].cross(e)};
}

inline std::vector<Vector3> normals_of(const ContactNode& node) {
  std::vector<Vector3> normals;
  for (const ContactSide& side : node.sides) normals.push_back(side.normal);
  return normals;
}

inline std::vector<Vector3> active_normals(const ContactNode& node) {
  std::vector<Vector3> normals;
  for (const ContactSide& side : node.sides)
    if (side.active) normals.push_back(side.normal);
  return normals;
}

// The friction of all sides that press.
inline double slip_friction(const ContactNode& node) {
  double sum = 0.0;
  for (std::size_t s = 0; s < node.sides.size(); ++s)
    if (node.sides[s].active) sum += sliding_coefficient_of(node.sides[s].friction);
  return sum;
}

// The projection of a vector onto the directions in which a node can slide.
inline Vector3 project_onto(const std::vector<Vector3>& directions, const Vector3& v) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& e : directions) sum += e * e.dot(v);
  return sum;
}

}  // namespace springnet
