// Pairs of near points, from a grid of cubes as wide as the radius.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/mesh.hpp>

namespace springnet {
namespace {

using Cube = std::array<std::int64_t, 3>;

// Distances to be computed, for each point: more mean that the radius is that of the whole cloud.
constexpr std::size_t most_distances = 20'000;

[[nodiscard]] Cube cube_of(const Vector3& point, const Vector3& lower, double width) {
  Cube result{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    result[axis] = static_cast<std::int64_t>(std::floor((point[i] - lower[i]) / width));
  }
  return result;
}

struct Candidate {
  double square;
  std::uint32_t point;
  [[nodiscard]] bool operator<(const Candidate& other) const {
    return square != other.square ? square < other.square : point < other.point;
  }
};

}  // namespace

std::vector<Edge> near_pairs(std::span<const Vector3> points, double radius, std::size_t most) {
  if (!(radius > 0.0) || !std::isfinite(radius))
    throw Error(ErrorKind::input, fmt::format("the radius is {} m, must be above 0", radius));
  if (most == 0) throw Error(ErrorKind::input, "each point has 0 neighbours; give 1 or more");
  if (points.empty()) return {};
  Vector3 lower = points[0], upper = points[0];
  for (const Vector3& point : points) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
  }
  // A cube's number has to fit: in a cloud that wide no two of these are near by chance of rounding.
  if (!((upper - lower).maxCoeff() / radius < 1e15))
    throw Error(ErrorKind::input,
                fmt::format("the radius of {:g} m is too small for points that are up to {:g} m apart; "
                            "give a greater one",
                            radius, (upper - lower).maxCoeff()));
  struct Entry {
    Cube cube;
    std::uint32_t point;
  };
  std::vector<Entry> sorted;
  sorted.reserve(points.size());
  for (std::size_t k = 0; k < points.size(); ++k)
    sorted.push_back({cube_of(points[k], lower, radius), static_cast<std::uint32_t>(k)});
  std::sort(sorted.begin(), sorted.end(),
            [](const Entry& a, const Entry& b) { return a.cube != b.cube ? a.cube < b.cube : a.point < b.point; });
  const double square = radius * radius;
  std::size_t distances = 0;
  std::vector<Candidate> near;
  std::vector<Edge> result;
  for (std::uint32_t k = 0; k < points.size(); ++k) {
    const Cube own = cube_of(points[k], lower, radius);
    near.clear();
    for (std::int64_t x = -1; x <= 1; ++x)
      for (std::int64_t y = -1; y <= 1; ++y) {
        // The three cubes along z follow each other.
        const auto by_cube = [](const Entry& entry, const Cube& cube) { return entry.cube < cube; };
        const Cube first{own[0] + x, own[1] + y, own[2] - 1}, end{own[0] + x, own[1] + y, own[2] + 2};
        const auto from = std::lower_bound(sorted.begin(), sorted.end(), first, by_cube);
        for (auto entry = from; entry != sorted.end() && entry->cube < end; ++entry) {
          ++distances;
          const double apart = (points[entry->point] - points[k]).squaredNorm();
          if (entry->point != k && apart <= square) near.push_back({apart, entry->point});
        }
      }
    if (distances > most_distances * points.size())
      throw Error(
          ErrorKind::input,
          fmt::format("within the radius of {:g} m points have thousands of others, point {} {}; give a smaller "
                      "radius",
                      radius, k, near.size()));
    const std::size_t kept = std::min(most, near.size());
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(kept), near.end());
    for (std::size_t i = 0; i < kept; ++i) {
      if (near[i].square == 0.0)
        throw Error(ErrorKind::input, fmt::format("points {} and {} are at the same place; leave one out",
                                                  std::min(k, near[i].point), std::max(k, near[i].point)));
      result.emplace_back(std::min(k, near[i].point), std::max(k, near[i].point));
    }
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

}  // namespace springnet
