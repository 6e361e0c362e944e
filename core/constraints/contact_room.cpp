// Whether surfaces that close in on a node leave it any room.

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "constraints/contact.hpp"

namespace springnet {
namespace {

// Unit normals are opposed if a positive combination with largest factor 1 vanishes to this tolerance.
constexpr double opposed = 1e-6;

// By how much these surfaces overlap, m. If their normals n_i are opposed, sum x_i n_i = 0 with x > 0, then sum x_i
// gap_i is the same at every nearby point, and all gaps can be non-negative only if it is (Farkas' lemma, for the
// tangent planes). 0: there is room, or a subset of the surfaces decides.
double overlap(const Eigen::Matrix3Xd& normals, const Eigen::VectorXd& gaps) {
  Eigen::FullPivLU<Eigen::Matrix3Xd> factors(normals);
  factors.setThreshold(opposed);
  if (factors.dimensionOfKernel() != 1) return 0.0;
  Eigen::VectorXd x = factors.kernel().col(0);
  if (x.sum() < 0.0) x = -x;
  x /= x.maxCoeff();
  if (x.minCoeff() <= opposed) return 0.0;
  return std::max(0.0, -x.dot(gaps) / x.sum());
}

}  // namespace

std::vector<std::int32_t> Contact::closed_around(const Placement& at, const Vector3& position, double tolerance) const {
  // A surface takes part only if its gap is at most the depth of the node behind the deepest surface.
  double deepest = tolerance;
  for (std::size_t j = 0; j < obstacles_.size(); ++j) deepest = std::max(deepest, -Contact::gap(at, j, position));
  std::vector<std::int32_t> near;
  std::vector<Vector3> normals;
  std::vector<double> gaps;
  for (std::size_t j = 0; j < obstacles_.size(); ++j) {
    const double gap = Contact::gap(at, j, position);
    if (gap > deepest) continue;
    near.push_back(static_cast<std::int32_t>(j));
    normals.push_back(normal(at, j, position));
    gaps.push_back(gap);
  }
  // A minimal set of opposed normals in space has at most four members.
  std::vector<std::size_t> chosen;
  const auto closed = [&](const auto& self, std::size_t from, std::size_t count) -> bool {
    if (count == 0) {
      const auto size = static_cast<Eigen::Index>(chosen.size());
      Eigen::Matrix3Xd n(3, size);
      Eigen::VectorXd g(size);
      for (Eigen::Index i = 0; i < size; ++i) {
        n.col(i) = normals[chosen[static_cast<std::size_t>(i)]];
        g[i] = gaps[chosen[static_cast<std::size_t>(i)]];
      }
      return overlap(n, g) > tolerance;
    }
    for (std::size_t i = from; i + count <= near.size(); ++i) {
      chosen.push_back(i);
      if (self(self, i + 1, count - 1)) return true;
      chosen.pop_back();
    }
    return false;
  };
  for (std::size_t count = 2; count <= 4; ++count) {
    if (!closed(closed, 0, count)) continue;
    std::vector<std::int32_t> result;
    for (const std::size_t i : chosen) result.push_back(near[i]);
    return result;
  }
  return {};
}

}  // namespace springnet
