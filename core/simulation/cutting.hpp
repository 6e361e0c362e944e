// Springs that cross a polygon.
#pragma once

#include <vector>

#include <springnet/network.hpp>

namespace springnet {

// A planar polygon of three or more corners, convex or not. Throws Error(input) if its corners span no area or do not
// lie in one plane.
class CuttingPolygon {
 public:
  explicit CuttingPolygon(const std::vector<Vector3>& corners);
  // Whether the segment from a to b passes through the polygon. A segment that lies in the plane does not.
  [[nodiscard]] bool crosses(const Vector3& a, const Vector3& b) const;

 private:
  Vector3 point_, normal_;
  Eigen::Index u_, v_;  // coordinates in which the polygon is projected: those it is widest in
  std::vector<Vector3> corners_;
};

}  // namespace springnet
