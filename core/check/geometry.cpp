#include "check/geometry.hpp"

#include <cmath>

#include <Eigen/Dense>

#include "check/differences.hpp"
#include "network/invariant_values.hpp"

namespace springnet::check {
namespace {

double scalar_of(const springnet_invariant& one, const Corners& corners) {
  const auto point = [&](std::size_t k) {
    const auto& c = corners[one.corners[k]];
    return invariants::Point{c[0], c[1], c[2]};
  };
  switch (one.kind) {
    case SPRINGNET_LENGTH:
      return invariants::length(point(0), point(1));
    case SPRINGNET_ANGLE:
      return invariants::angle(point(0), point(1), point(2));
    case SPRINGNET_AREA:
      return invariants::area(point(0), point(1), point(2));
    case SPRINGNET_VOLUME:
      return invariants::volume(point(0), point(1), point(2), point(3));
    default:
      return invariants::dihedral(point(0), point(1), point(2), point(3));
  }
}

}  // namespace

Corners corners_of(std::uint32_t shape) {
  switch (shape) {
    case SPRINGNET_CHAIN:
      return {{1, 0, 0}, {0, 0, 0}, {-0.3, 0.9, 0.1}};
    case SPRINGNET_TRIANGLE:
      return {{0, 0, 0}, {1, 0.1, 0}, {0.3, 0.95, 0.1}};
    case SPRINGNET_HINGE:
      return {{0, 0, 0}, {1, 0.1, 0}, {0.4, 0.9, 0.2}, {0.5, -0.8, 0.1}};
    default:
      return {{0, 0, 0}, {1, 0.1, 0}, {0.3, 0.95, 0.1}, {0.35, 0.3, 0.85}};
  }
}

std::vector<double> scalars_of(const springnet_law& law, const Corners& corners) {
  std::vector<double> values;
  for (std::uint32_t i = 0; i < law.invariant_count; ++i) values.push_back(scalar_of(*law.invariants[i], corners));
  return values;
}

std::vector<std::vector<double>> gradients_of(const springnet_law& law, const Corners& corners) {
  const double size =
      std::hypot(corners[1][0] - corners[0][0], corners[1][1] - corners[0][1], corners[1][2] - corners[0][2]);
  std::vector<std::vector<double>> gradients(law.invariant_count, std::vector<double>(3 * corners.size()));
  for (std::size_t k = 0; k < 3 * corners.size(); ++k) {
    const Functions functions = [&](const std::vector<double>& xs) {
      std::vector<std::vector<double>> values(law.invariant_count);
      Corners moved = corners;
      for (const double x : xs) {
        moved[k / 3][k % 3] = x;
        const std::vector<double> scalars = scalars_of(law, moved);
        for (std::size_t i = 0; i < scalars.size(); ++i) values[i].push_back(scalars[i]);
      }
      return values;
    };
    const std::vector<Slope> found = slopes(functions, corners[k / 3][k % 3], 0.1 * size);
    for (std::size_t i = 0; i < found.size(); ++i) gradients[i][k] = found[i].value;
  }
  return gradients;
}

std::array<double, 3> direction_of(const Corners& rest, const std::array<double, 3>& direction) {
  const Eigen::Vector3d a(direction[0], direction[1], direction[2]);
  Eigen::MatrixXd edges(3, rest.size() - 1);
  for (std::size_t k = 1; k < rest.size(); ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      edges(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(k - 1)) = rest[k][axis] - rest[0][axis];
  // Of a triangle the part in its plane.
  Eigen::VectorXd components = edges.colPivHouseholderQr().solve(a);
  components /= (edges * components).norm();
  std::array<double, 3> result{};
  for (Eigen::Index k = 0; k < components.size(); ++k) result[static_cast<std::size_t>(k)] = components[k];
  return result;
}

}  // namespace springnet::check
