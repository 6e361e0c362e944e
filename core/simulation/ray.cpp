// Where a ray first meets a face of a body, a plane or an instrument.
#include <springnet/simulation.hpp>

#include <array>
#include <cmath>
#include <limits>

#include "constraints/vectors.hpp"
#include "simulation/implementation.hpp"

namespace springnet {
namespace {

// Triangles in coordinates in which the ray goes along z, sheared so that the sides of neighbours get the same numbers
// and a ray never slips between them: S. Woop, C. Benthin, I. Wald, Watertight Ray/Triangle Intersection, J. Computer
// Graphics Techniques 2(1), 2013.
class Ray {
 public:
  Ray(const Vector3& origin, const Vector3& direction) : origin_(origin) {
    direction.cwiseAbs().maxCoeff(&z_);
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    shear_ = {direction[x_] / direction[z_], direction[y_] / direction[z_], 1.0 / direction[z_]};
  }

  // Distance along the ray, in lengths of its direction; below 0: not met.
  [[nodiscard]] double distance_to(const std::array<Vector3, 3>& corners) const {
    std::array<Vector3, 3> p;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3 d = corners[i] - origin_;
      p[i] = {d[x_] - shear_[0] * d[z_], d[y_] - shear_[1] * d[z_], shear_[2] * d[z_]};
    }
    const auto side = [](const Vector3& a, const Vector3& b) { return a[0] * b[1] - a[1] * b[0]; };
    const Vector3 weight{side(p[1], p[2]), side(p[2], p[0]), side(p[0], p[1])};
    if (weight.minCoeff() < 0.0 && weight.maxCoeff() > 0.0) return -1.0;
    const double sum = weight.sum();
    if (sum == 0.0) return -1.0;  // seen from its edge
    return (weight[0] * p[0][2] + weight[1] * p[1][2] + weight[2] * p[2][2]) / sum;
  }

 private:
  Vector3 origin_, shear_;
  Eigen::Index x_ = 0, y_ = 0, z_ = 0;
};

}  // namespace

std::optional<RayHit> Simulation::cast_ray(const Vector3& origin, const Vector3& direction) const {
  const double length = direction.norm();
  if (!origin.allFinite() || !direction.allFinite() || !(length > 0.0) || !std::isfinite(length))
    throw Error(
        ErrorKind::input,
        fmt::format("cast_ray: from ({}, {}, {}) in the direction ({}, {}, {}): the numbers must be finite, and "
                    "the direction have a length above 0",
                    origin[0], origin[1], origin[2], direction[0], direction[1], direction[2]));
  const Vector3 unit = direction / length;
  const Ray ray(origin, unit);
  const springnet_vectors& p = impl_->engine.model().state.view.position;
  const std::vector<std::uint32_t>& columns = this->columns();
  const std::vector<Face>& faces = impl_->network->faces();
  const std::vector<std::uint8_t>& torn = impl_->torn_faces.of(*impl_->network, impl_->engine.model().layout);
  std::optional<RayHit> hit;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (torn[f] != 0) continue;
    const Face& face = faces[f];
    const double distance = ray.distance_to(
        {vector_at(p, columns[face[0]]), vector_at(p, columns[face[1]]), vector_at(p, columns[face[2]])});
    if (!(distance >= 0.0 && distance < nearest)) continue;
    nearest = distance;
    hit = RayHit{nearest, origin + nearest * unit, static_cast<std::int64_t>(f), -1, 0};
  }
  for (std::size_t j = 0; j < surface_count(); ++j) {
    const std::optional<double> at = impl_->surface(j).meets(impl_->pose(j), origin, unit);
    if (!at || !(*at < nearest)) continue;
    nearest = *at;
    hit = RayHit{nearest, origin + nearest * unit, -1, static_cast<std::int32_t>(j), 0};
  }
  if (hit && hit->face >= 0) {
    double least = std::numeric_limits<double>::infinity();
    for (const NodeIndex corner : faces[static_cast<std::size_t>(hit->face)]) {
      const double distance = (vector_at(p, columns[corner]) - hit->point).squaredNorm();
      if (distance >= least) continue;
      least = distance;
      hit->node = corner;
    }
  }
  return hit;
}

}  // namespace springnet
