// Neighbours in clouds of points, against all pairs.
#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/mesh.hpp>

#include "refusal.hpp"

namespace springnet::testing {
namespace {

std::vector<Vector3> cloud(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(-1.0, 1.0);
  std::vector<Vector3> points;
  for (std::size_t k = 0; k < count; ++k)
    points.emplace_back(within(random), 0.5 * within(random), 3.0 + within(random));
  return points;
}

std::vector<Edge> of_all_pairs(const std::vector<Vector3>& points, double radius, std::size_t most) {
  std::set<Edge> result;
  for (std::uint32_t k = 0; k < points.size(); ++k) {
    std::vector<std::pair<double, std::uint32_t>> others;
    for (std::uint32_t j = 0; j < points.size(); ++j)
      if (const double square = (points[j] - points[k]).squaredNorm(); j != k && square <= radius * radius)
        others.emplace_back(square, j);
    std::sort(others.begin(), others.end());
    others.resize(std::min(most, others.size()));
    for (const auto& [square, j] : others) result.emplace(std::min(k, j), std::max(k, j));
  }
  return {result.begin(), result.end()};
}

TEST_CASE("neighbours are the nearest points within the radius") {
  const std::vector<Vector3> points = cloud(400, 3);
  for (const double radius : {0.01, 0.1, 0.3, 5.0})
    for (const std::size_t most : {1U, 4U, 30U, 1000U}) {
      CAPTURE(radius);
      CAPTURE(most);
      const std::vector<Edge> found = near_pairs(points, radius, most);
      CHECK(found == of_all_pairs(points, radius, most));
    }
  CHECK(near_pairs(points, 0.3, 4).size() > 800);
  CHECK(near_pairs({}, 1.0, 4).empty());
  CHECK(near_pairs(std::vector<Vector3>{{1, 2, 3}}, 1.0, 4).empty());
}

TEST_CASE("of equally near points those of lower numbers are taken; one at the radius counts") {
  const std::vector<Vector3> points{{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, 0, -2}};
  CHECK(near_pairs(points, 1.0, 1) == std::vector<Edge>{{0, 1}, {0, 2}, {0, 3}});
  CHECK(near_pairs(std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}}, 1.0, 1) ==
        std::vector<Edge>{{0, 1}, {0, 2}});
  CHECK(near_pairs(points, 2.0, 4).size() == 7);
}

TEST_CASE("clouds that have no neighbours, or too many, are refused") {
  const auto refused = [](const std::vector<Vector3>& points, double radius, std::size_t most) {
    return refusal_of([&] { static_cast<void>(near_pairs(points, radius, most)); });
  };
  CHECK(refused({{0, 0, 0}}, 0.0, 3) == "the radius is 0 m, must be above 0");
  CHECK(refused({{0, 0, 0}}, 1.0, 0) == "each point has 0 neighbours; give 1 or more");
  CHECK(refused({{0, 0, 0}, {1, 1, 1}, {0, 0, 0}}, 1.0, 3) == "points 0 and 2 are at the same place; leave one out");
  // However large the radius is.
  const std::vector<Vector3> many = cloud(5'000, 1);
  CHECK(near_pairs(many, 1e9, 6).size() >= 15'000);
  CHECK(refused(many, 1e9, 5'000).find("more than 20000000 pairs of points are within 1e+09 m") != std::string::npos);
}

}  // namespace
}  // namespace springnet::testing
