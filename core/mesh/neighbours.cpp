// Pairs of near points of a cloud.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>

#include <springnet/error.hpp>
#include <springnet/mesh.hpp>

namespace springnet {
namespace {

namespace index = boost::geometry::index;
using Point = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;
using Box = boost::geometry::model::box<Point>;
using Entry = std::pair<Point, std::uint32_t>;
using Tree = index::rtree<Entry, index::quadratic<16>>;

[[nodiscard]] Point point_of(const Vector3& p) { return {p.x(), p.y(), p.z()}; }

struct Near {
  double square;  // of the distance, m^2
  std::uint32_t point;
  [[nodiscard]] bool operator<(const Near& other) const {
    return square != other.square ? square < other.square : point < other.point;
  }
};

class Neighbours {
 public:
  explicit Neighbours(std::span<const Vector3> points) : points_(points) {
    std::vector<Entry> entries;
    entries.reserve(points.size());
    for (std::size_t k = 0; k < points.size(); ++k)
      entries.emplace_back(point_of(points[k]), static_cast<std::uint32_t>(k));
    tree_ = Tree(entries);
  }

  // The nearest others, at most so many within a radius, by distance and number; valid until the next call.
  [[nodiscard]] const std::vector<Near>& of(std::uint32_t k, double radius, std::size_t most) {
    // Of equally near points the tree has any: so all are taken that are as near as the last.
    found_.clear();
    const Vector3 within = Vector3::Constant(radius);
    tree_.query(index::intersects(Box(point_of(points_[k] - within), point_of(points_[k] + within))) &&
                    index::nearest(point_of(points_[k]), static_cast<unsigned>(std::min(most, points_.size()) + 1)),
                std::back_inserter(found_));
    double reach = 0.0;
    for (const auto& [place, other] : found_) reach = std::max(reach, square_of(k, other));
    reach = std::min(std::sqrt(reach), radius);
    const Vector3 around = Vector3::Constant(reach * (1.0 + 1e-14)) + 1e-15 * points_[k].cwiseAbs();
    found_.clear();
    tree_.query(index::intersects(Box(point_of(points_[k] - around), point_of(points_[k] + around))),
                std::back_inserter(found_));
    near_.clear();
    for (const auto& [place, other] : found_)
      if (const double square = square_of(k, other); other != k && square <= radius * radius)
        near_.push_back({square, other});
    const std::size_t kept = std::min(most, near_.size());
    std::partial_sort(near_.begin(), near_.begin() + static_cast<std::ptrdiff_t>(kept), near_.end());
    near_.resize(kept);
    return near_;
  }

 private:
  [[nodiscard]] double square_of(std::uint32_t a, std::uint32_t b) const {
    return (points_[a] - points_[b]).squaredNorm();
  }

  std::span<const Vector3> points_;
  Tree tree_;
  std::vector<Entry> found_;
  std::vector<Near> near_;
};

}  // namespace

std::vector<Edge> near_pairs(std::span<const Vector3> points, double radius, std::size_t most) {
  if (!(radius > 0.0) || !std::isfinite(radius))
    throw Error(ErrorKind::input, fmt::format("the radius is {} m, must be above 0", radius));
  if (most == 0) throw Error(ErrorKind::input, "each point has 0 neighbours; give 1 or more");
  Neighbours neighbours(points);
  std::vector<Edge> result;
  for (std::uint32_t k = 0; k < points.size(); ++k) {
    const std::vector<Near>& near = neighbours.of(k, radius, most);
    if (result.size() + near.size() > most_near_pairs)
      throw Error(ErrorKind::input,
                  fmt::format("more than {} pairs of points are within {:g} m; give a smaller radius or "
                              "fewer neighbours",
                              most_near_pairs, radius));
    for (const auto& [square, other] : near) {
      if (square == 0.0)
        throw Error(ErrorKind::input, fmt::format("points {} and {} are at the same place; leave one out",
                                                  std::min(k, other), std::max(k, other)));
      result.emplace_back(std::min(k, other), std::max(k, other));
    }
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

}  // namespace springnet
