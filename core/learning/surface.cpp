#include "learning/surface.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

namespace springnet::learning {

namespace {

constexpr std::uint32_t most_in_leaf = 4;
constexpr double flat = 1e-20;  // square of the sine of an angle below which a triangle is a line

// Weights of the point of a segment that is nearest to p.
Vector3 on_segment(const Vector3& a, const Vector3& b, const Vector3& p) {
  const double length = (b - a).squaredNorm();
  const double share = length > 0.0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0.0;
  return {1.0 - share, share, 0.0};
}

// Weights of the point of a triangle that is nearest to p (C. Ericson, Real-Time Collision Detection, 5.1.5).
Vector3 on_triangle(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p) {
  const Vector3 ab = b - a, ac = c - a;
  if (ab.cross(ac).squaredNorm() <= flat * ab.squaredNorm() * ac.squaredNorm()) {
    const Vector3 on_ab = on_segment(a, b, p), on_bc = on_segment(b, c, p), on_ca = on_segment(c, a, p);
    const Vector3 all[3] = {on_ab, {0.0, on_bc[0], on_bc[1]}, {on_ca[1], 0.0, on_ca[0]}};
    const auto distance = [&](const Vector3& w) { return (w[0] * a + w[1] * b + w[2] * c - p).squaredNorm(); };
    return *std::min_element(all, all + 3,
                             [&](const Vector3& x, const Vector3& y) { return distance(x) < distance(y); });
  }
  const double d1 = ab.dot(p - a), d2 = ac.dot(p - a);
  if (d1 <= 0.0 && d2 <= 0.0) return {1, 0, 0};
  const double d3 = ab.dot(p - b), d4 = ac.dot(p - b);
  if (d3 >= 0.0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const double d5 = ab.dot(p - c), d6 = ac.dot(p - c);
  if (d6 >= 0.0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {1.0 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
    const double share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1.0 - share, share};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

}  // namespace

Surface::Surface(const Network& network) : positions_(3, static_cast<Eigen::Index>(network.nodes().size())) {
  const std::size_t nodes = network.nodes().size(), bodies = network.bodies().size();
  // What is outside of bodies is a body, too.
  std::vector<std::size_t> body_of(nodes, bodies);
  std::vector<std::uint8_t> has_faces(bodies + 1, 0);
  for (std::size_t b = 0; b < bodies; ++b) {
    const Body& body = network.bodies()[b];
    std::fill_n(body_of.begin() + body.first_node, body.node_count, b);
  }
  for (const Face& face : network.faces()) {
    faces_.push_back(face);
    for (const NodeIndex node : face) has_faces[body_of[node]] = 1;
  }
  for (NodeIndex k = 0; k < nodes; ++k)
    if (has_faces[body_of[k]] == 0) faces_.push_back({k, k, k});
  std::vector<Vector3> middles;
  const std::vector<Vector3>& at = network.nodes().positions();
  for (const auto& face : faces_) middles.emplace_back(at[face[0]] + at[face[1]] + at[face[2]]);
  parts_.resize(faces_.size());
  std::iota(parts_.begin(), parts_.end(), 0u);
  if (!parts_.empty()) build(0, static_cast<std::uint32_t>(parts_.size()), middles);
  for (std::size_t k = 0; k < nodes; ++k) positions_.col(static_cast<Eigen::Index>(k)) = at[k];
  move(Eigen::Matrix3Xd(positions_));
}

void Surface::build(std::uint32_t first, std::uint32_t count, const std::vector<Vector3>& middles) {
  const std::size_t own = boxes_.size();
  boxes_.push_back({Vector3::Zero(), Vector3::Zero(), first, count <= most_in_leaf ? count : 0, 0});
  if (count <= most_in_leaf) return;
  Vector3 least = middles[parts_[first]], greatest = least;
  for (std::uint32_t k = first; k < first + count; ++k) {
    least = least.cwiseMin(middles[parts_[k]]);
    greatest = greatest.cwiseMax(middles[parts_[k]]);
  }
  Eigen::Index axis = 0;
  (greatest - least).maxCoeff(&axis);
  const std::uint32_t half = count / 2;
  const auto begin = parts_.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(middles[a][axis], a) < std::pair(middles[b][axis], b);
  });
  build(first, half, middles);
  boxes_[own].second = static_cast<std::uint32_t>(boxes_.size());
  build(first + half, count - half, middles);
}

void Surface::move(const Eigen::Matrix3Xd& positions) {
  positions_ = positions;
  for (std::size_t k = boxes_.size(); k-- > 0;) {  // children stand behind their parents
    Box& box = boxes_[k];
    box.least.setConstant(std::numeric_limits<double>::infinity());
    box.greatest = -box.least;
    for (std::uint32_t part = box.first; part < box.first + box.count; ++part)
      for (const NodeIndex node : faces_[parts_[part]]) {
        box.least = box.least.cwiseMin(positions_.col(node));
        box.greatest = box.greatest.cwiseMax(positions_.col(node));
      }
    if (box.count > 0) continue;
    for (const Box* const child : {&boxes_[k + 1], &boxes_[box.second]}) {
      box.least = box.least.cwiseMin(child->least);
      box.greatest = box.greatest.cwiseMax(child->greatest);
    }
  }
}

Surface::Nearest Surface::nearest_of(std::uint32_t part, const Vector3& point) const {
  Nearest result;
  result.nodes = faces_[part];
  const Vector3 corner[3] = {positions_.col(result.nodes[0]), positions_.col(result.nodes[1]),
                             positions_.col(result.nodes[2])};
  result.weights = on_triangle(corner[0], corner[1], corner[2], point);
  result.point = result.weights[0] * corner[0] + result.weights[1] * corner[1] + result.weights[2] * corner[2];
  return result;
}

Surface::Nearest Surface::nearest(const Vector3& point) const {
  Nearest best;
  double least = std::numeric_limits<double>::infinity();
  std::uint32_t best_part = std::numeric_limits<std::uint32_t>::max();
  const auto distance_to = [&](std::uint32_t box) {
    return (boxes_[box].least - point).cwiseMax(point - boxes_[box].greatest).cwiseMax(0.0).squaredNorm();
  };
  std::vector<std::pair<double, std::uint32_t>> open{{0.0, 0u}};
  while (!open.empty()) {
    const auto [distance, number] = open.back();
    open.pop_back();
    if (distance > least) continue;
    const Box& box = boxes_[number];
    for (std::uint32_t k = box.first; k < box.first + box.count; ++k) {
      const Nearest own = nearest_of(parts_[k], point);
      const double its = (own.point - point).squaredNorm();
      if (std::pair(its, parts_[k]) >= std::pair(least, best_part)) continue;
      least = its;
      best_part = parts_[k];
      best = own;
    }
    if (box.count > 0) continue;
    std::pair<double, std::uint32_t> children[2] = {{distance_to(number + 1), number + 1},
                                                    {distance_to(box.second), box.second}};
    if (children[0].first < children[1].first) std::swap(children[0], children[1]);
    open.insert(open.end(), children, children + 2);  // the nearer one is looked at first
  }
  const auto corner = [&](std::size_t i) -> Vector3 { return positions_.col(best.nodes[i]); };
  const auto inside = (best.weights.array() > 0.0).count();
  if (inside == 3) {
    const Vector3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    best.normal = normal * normal.transpose();
  } else if (inside == 2) {
    const std::size_t off = best.weights[0] > 0.0 ? best.weights[1] > 0.0 ? 2 : 1 : 0;
    const Vector3 along = (corner((off + 1) % 3) - corner((off + 2) % 3)).normalized();
    best.normal -= along * along.transpose();
  }
  return best;
}

}  // namespace springnet::learning
