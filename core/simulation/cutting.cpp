#include "simulation/cutting.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include <springnet/error.hpp>

namespace springnet {

CuttingPolygon::CuttingPolygon(const std::vector<Vector3>& corners) : corners_(corners) {
  if (corners.size() < 3)
    throw Error(ErrorKind::input, fmt::format("a cutting polygon needs three corners or more, has {}", corners.size()));
  // Newell's formula: twice the area as a vector, for any planar polygon.
  Vector3 area = Vector3::Zero();
  double size = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3 edge = corners[(i + 1) % corners.size()] - corners[i];
    area += (corners[i] - corners[0]).cross(edge);
    size = std::max(size, (corners[i] - corners[0]).norm());
  }
  if (!area.allFinite() || area.norm() <= 1e-12 * size * size)
    throw Error(ErrorKind::input, "a cutting polygon spans no area: its corners lie on a line or coincide");
  normal_ = area.normalized();
  point_ = corners[0];
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double off = std::abs(normal_.dot(corners[i] - point_));
    if (off > 1e-6 * size)
      throw Error(
          ErrorKind::input,
          fmt::format("corner {} of a cutting polygon lies {:.3g} m outside the plane of the others; give planar "
                      "polygons, or several triangles",
                      i, off));
  }
  Eigen::Index drop = 0;
  normal_.cwiseAbs().maxCoeff(&drop);
  u_ = (drop + 1) % 3;
  v_ = (drop + 2) % 3;
}

bool CuttingPolygon::crosses(const Vector3& a, const Vector3& b) const {
  const double da = normal_.dot(a - point_), db = normal_.dot(b - point_);
  if ((da < 0.0) == (db < 0.0)) return false;
  const Vector3 hit = a + (da / (da - db)) * (b - a);
  // Even-odd rule: a ray from the point along u crosses the edges an odd number of times.
  bool inside = false;
  for (std::size_t i = 0, j = corners_.size() - 1; i < corners_.size(); j = i++) {
    const Vector3 &p = corners_[i], &q = corners_[j];
    if ((p[v_] > hit[v_]) != (q[v_] > hit[v_]) &&
        hit[u_] < (q[u_] - p[u_]) * (hit[v_] - p[v_]) / (q[v_] - p[v_]) + p[u_])
      inside = !inside;
  }
  return inside;
}

}  // namespace springnet
