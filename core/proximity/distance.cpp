#include "proximity/distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace springnet::proximity {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
// Squared sine below which corners of a triangle, or two edges, count as nearly on one line. The weights of points
// between the edges then lose digits; edges and ends are tried as well, which are never far.
constexpr double nearly_parallel = 1e-6;
// Below this the product of both directions is rounding for the most part, and points anywhere.
constexpr double without_normal = 1e-16;

// The closest points found so far. `normal` is perpendicular to both primitives at these; zero if only the difference
// of the points says so.
struct Closest {
  double squared = std::numeric_limits<double>::infinity();  // m^2
  Vector3 difference = Vector3::Zero();                      // m, first point less second
  Vector3 normal = Vector3::Zero();                          // of any length
  Vector3 along = Vector3::Zero();                           // an edge that has one of the points between its ends
  std::array<double, 4> weights{};

  [[nodiscard]] bool is_of_ends() const { return normal.isZero(0.0) && along.isZero(0.0); }
  void replace(const Vector3& other) {
    difference = other;
    squared = other.squaredNorm();
  }
  bool improves(const Vector3& other) {
    const double now = other.squaredNorm();
    if (!(now < squared)) return false;
    squared = now;
    difference = other;
    return true;
  }
};

// The share of the segment from `a` along `e` at which it is closest to the origin.
double share_of_segment(const Vector3& a, const Vector3& e) {
  const double length = e.squaredNorm();
  return length > 0.0 ? std::clamp(-a.dot(e) / length, 0.0, 1.0) : 0.0;
}

// Whether a distance exceeds another one by rounding at most, m, of an edge of this length.
bool is_as_near(double distance, double other, double length) {
  return distance - other <= 16.0 * epsilon * (distance + length);
}

// A point, as `point` of the four weights, against the segment from node `from` to node `to`. relative: the segment's
// ends less the point; sign: 1 if the point belongs to the first primitive, else -1.
void consider_segment(Closest& best, std::size_t point, std::size_t from, std::size_t to, const Vector3& a,
                      const Vector3& b, double sign) {
  const Vector3 e = b - a;
  const double t = share_of_segment(a, e);
  // From the nearer end, so that a point close to it keeps its digits.
  const Vector3 to_segment = t <= 0.5 ? Vector3(a + t * e) : Vector3(b - (1.0 - t) * e);
  const bool is_between = t > 0.0 && t < 1.0;
  const Closest before = best;
  if (!best.improves(-sign * to_segment)) {
    // Of distances that are equal but for rounding the one beside an end says less of the direction.
    if (!is_between || !best.is_of_ends() || !is_as_near(to_segment.norm(), std::sqrt(best.squared), e.norm())) return;
    best.replace(-sign * to_segment);
  } else if (!is_between && !before.is_of_ends() &&
             is_as_near(std::sqrt(before.squared), to_segment.norm(), e.norm())) {
    best = before;
    return;
  }
  best.weights = {};
  best.weights[point] = sign;
  best.weights[from] = -sign * (1.0 - t);
  best.weights[to] = -sign * t;
  best.normal.setZero();
  best.along = is_between ? e : Vector3(Vector3::Zero());
}

// A unit vector perpendicular to `e`; UnitX if that is zero.
Vector3 perpendicular_to(const Vector3& e) {
  const double largest = e.cwiseAbs().maxCoeff();
  if (!(largest > 0.0)) return Vector3::UnitX();
  const Vector3 unit = e / largest;
  Eigen::Index axis = 0;
  unit.cwiseAbs().minCoeff(&axis);
  return unit.cross(Vector3(Vector3::Unit(axis))).normalized();
}

// A unit vector, nearly perpendicular to `e`, made so to the last digit: both ends of the edge are then equally far in
// this direction. As it is if e is zero.
Vector3 perpendicular_to(const Vector3& e, const Vector3& unit) {
  const double length = e.squaredNorm();
  return length > 0.0 ? Vector3(unit - e * (unit.dot(e) / length)).normalized() : unit;
}

// extent: m, of the pair; fallback: perpendicular to both primitives if possible, of any length; longest: an edge.
Separation finish(const Closest& best, double extent, const Vector3& fallback, const Vector3& longest) {
  Separation found;
  found.weights = best.weights;
  found.distance = std::sqrt(best.squared);
  const bool is_clear = found.distance > 16.0 * epsilon * extent;
  if (best.normal.squaredNorm() > 0.0 || !is_clear) {
    // The direction of the difference would be lost in rounding; that of the plane is not.
    const Vector3 normal = best.normal.squaredNorm() > 0.0 ? best.normal : fallback;
    if (const double length = normal.norm(); length > 0.0)
      found.direction = perpendicular_to(longest, normal / length);
    else
      found.direction = perpendicular_to(longest);
    if (found.direction.dot(best.difference) < 0.0) found.direction = -found.direction;
    return found;
  }
  found.direction = best.difference / found.distance;
  found.direction = perpendicular_to(best.along, found.direction);
  return found;
}

double extent_of(const Vector3& a, const Vector3& b, const Vector3& c) {
  return std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff()});
}

const Vector3& longest_of(const Vector3& a, const Vector3& b) { return a.squaredNorm() >= b.squaredNorm() ? a : b; }

Separation of_nodes(const std::array<Vector3, 4>& x) {
  Closest best;
  best.improves(x[0] - x[1]);
  best.weights = {1.0, -1.0, 0.0, 0.0};
  return finish(best, 0.0, Vector3::Zero(), Vector3::Zero());
}

Separation of_node_and_triangle(const std::array<Vector3, 4>& x) {
  const Vector3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];  // from the node
  const Vector3 ab = x[2] - x[1], ac = x[3] - x[1], bc = x[3] - x[2];
  const Vector3 normal = ab.cross(ac);
  const double area = normal.squaredNorm();
  const bool is_clear = area > nearly_parallel * ab.squaredNorm() * ac.squaredNorm();
  // Areas of the triangles between the node's projection and the edges, as shares of the whole.
  const double of_a = area > 0.0 ? b.cross(c).dot(normal) / area : -1.0;
  const double of_b = area > 0.0 ? c.cross(a).dot(normal) / area : -1.0;
  const double of_c = 1.0 - of_a - of_b;
  Closest best;
  if (of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0) {
    best.improves(-(a + of_b * ab + of_c * ac));
    best.weights = {1.0, -of_a, -of_b, -of_c};
    if (area > without_normal * ab.squaredNorm() * ac.squaredNorm()) best.normal = normal;
    if (is_clear) best.replace(normal * (-a.dot(normal) / area));  // the rest of the difference is rounding
  }
  // A point outside of the triangle is outside of the edge that is closest to it, unless the areas are rounding.
  if (of_c < 0.0 || !is_clear) consider_segment(best, 0, 1, 2, a, b, 1.0);
  if (of_a < 0.0 || !is_clear) consider_segment(best, 0, 2, 3, b, c, 1.0);
  if (of_b < 0.0 || !is_clear) consider_segment(best, 0, 3, 1, c, a, 1.0);
  return finish(best, extent_of(a, b, c), normal, longest_of(longest_of(ab, ac), bc));
}

// Edges whose directions differ clearly. The closest points of both lines; if one is beyond an end, the point of the
// other edge that is closest to this end, and so back (Ericson, section 5.1.9).
void consider_clear_edges(Closest& best, const Vector3& e, const Vector3& f, const Vector3& offset,
                          const Vector3& normal, double area) {
  const double s_line = offset.cross(f).dot(normal) / area, t_line = offset.cross(e).dot(normal) / area;
  if (s_line >= 0.0 && s_line <= 1.0 && t_line >= 0.0 && t_line <= 1.0) {
    best.improves(normal * (-offset.dot(normal) / area));
    best.weights = {1.0 - s_line, s_line, t_line - 1.0, -t_line};
    best.normal = normal;
    return;
  }
  double s = std::clamp(s_line, 0.0, 1.0);
  const double t_for_s = (s * e - offset).dot(f) / f.squaredNorm(), t = std::clamp(t_for_s, 0.0, 1.0);
  if (t != t_for_s) s = std::clamp((offset + t * f).dot(e) / e.squaredNorm(), 0.0, 1.0);
  best.improves(s * e - offset - t * f);
  best.weights = {1.0 - s, s, t - 1.0, -t};
  if (s > 0.0 && s < 1.0)
    best.along = e;
  else if (t > 0.0 && t < 1.0)
    best.along = f;
}

// Edges that are nearly parallel, or without length.
void consider_ends(Closest& best, const std::array<Vector3, 4>& x) {
  const Vector3 offset = x[2] - x[0], to_end = x[3] - x[0], from_end = x[2] - x[1], between_ends = x[3] - x[1];
  consider_segment(best, 0, 2, 3, offset, to_end, 1.0);
  consider_segment(best, 1, 2, 3, from_end, between_ends, 1.0);
  consider_segment(best, 2, 0, 1, -offset, -from_end, -1.0);
  consider_segment(best, 3, 0, 1, -to_end, -between_ends, -1.0);
}

Separation of_edges(const std::array<Vector3, 4>& x) {
  const Vector3 e = x[1] - x[0], f = x[3] - x[2], offset = x[2] - x[0];
  const Vector3 normal = e.cross(f);
  const double area = normal.squaredNorm();
  Closest best;
  if (area > nearly_parallel * e.squaredNorm() * f.squaredNorm()) {
    consider_clear_edges(best, e, f, offset, normal, area);
  } else {
    if (area > 0.0) {
      const double s = offset.cross(f).dot(normal) / area, t = offset.cross(e).dot(normal) / area;
      if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) {
        best.improves(s * e - offset - t * f);
        best.weights = {1.0 - s, s, t - 1.0, -t};
        // Along the edges the points, and so their difference, are rounding.
        if (area > without_normal * e.squaredNorm() * f.squaredNorm())
          best.normal = normal;
        else
          best.along = e;
      }
    }
    consider_ends(best, x);
  }
  return finish(best, std::max(extent_of(e, f, offset), (x[3] - x[0]).cwiseAbs().maxCoeff()), normal, longest_of(e, f));
}

}  // namespace

Separation separation(PairKind kind, const std::array<Vector3, 4>& x) {
  switch (kind) {
    case PairKind::node_node:
      return of_nodes(x);
    case PairKind::node_triangle:
      return of_node_and_triangle(x);
    case PairKind::edge_edge:
      break;
  }
  return of_edges(x);
}

Features features_of(PairKind kind, const std::array<double, 4>& weights, double least) {
  unsigned result = 0;
  for (int i = 0; i < first_nodes(kind) + second_nodes(kind); ++i)
    if (std::abs(weights[static_cast<std::size_t>(i)]) > least) result |= 1u << i;
  return static_cast<Features>(result);
}

bool are_nearly_parallel(PairKind kind, const std::array<Vector3, 4>& x) {
  if (kind != PairKind::edge_edge) return false;
  const Vector3 e = x[1] - x[0], f = x[3] - x[2];
  return !(e.cross(f).squaredNorm() > nearly_parallel * e.squaredNorm() * f.squaredNorm());
}

Separation separation_between(PairKind kind, const std::array<Vector3, 4>& x, Features features) {
  std::array<std::size_t, 4> places{};  // of the features' nodes
  std::size_t firsts = 0, count = 0;
  for (int i = 0; i < first_nodes(kind) + second_nodes(kind); ++i) {
    if ((features >> i & 1u) == 0) continue;
    places[count++] = static_cast<std::size_t>(i);
    if (i < first_nodes(kind)) ++firsts;
  }
  Separation found;
  Vector3 difference;
  std::array<double, 4>& w = found.weights;
  if (firsts == 1 && count == 2) {
    w[places[0]] = 1.0;
    w[places[1]] = -1.0;
    difference = x[places[0]] - x[places[1]];
  } else if (count == 3) {  // a point and a line
    const bool point_first = firsts == 1;
    const double sign = point_first ? 1.0 : -1.0;
    const std::size_t point = point_first ? places[0] : places[2], from = places[point_first ? 1 : 0],
                      to = places[point_first ? 2 : 1];
    const Vector3 a = x[from] - x[point], e = x[to] - x[from];
    const double length = e.squaredNorm();
    if (!(length > 0.0)) return separation(kind, x);
    const double t = -a.dot(e) / length;
    w[point] = sign;
    w[from] = -sign * (1.0 - t);
    w[to] = -sign * t;
    difference = -sign * Vector3(a - e * (a.dot(e) / length));
  } else if (count == 4 && kind == PairKind::node_triangle) {
    const Vector3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0], ab = x[2] - x[1], ac = x[3] - x[1];
    const Vector3 normal = ab.cross(ac);
    const double area = normal.squaredNorm();
    if (!(area > nearly_parallel * ab.squaredNorm() * ac.squaredNorm())) return separation(kind, x);
    const double of_b = c.cross(a).dot(normal) / area, of_c = a.cross(b).dot(normal) / area;
    w = {1.0, of_b + of_c - 1.0, -of_b, -of_c};
    difference = normal * (-a.dot(normal) / area);
  } else if (count == 4 && !are_nearly_parallel(kind, x)) {
    const Vector3 e = x[1] - x[0], f = x[3] - x[2], offset = x[2] - x[0], normal = e.cross(f);
    const double area = normal.squaredNorm();
    const double s = offset.cross(f).dot(normal) / area, t = offset.cross(e).dot(normal) / area;
    w = {1.0 - s, s, t - 1.0, -t};
    difference = normal * (-offset.dot(normal) / area);
  } else {
    return separation(kind, x);
  }
  found.distance = difference.norm();
  if (!(found.distance > 0.0)) return separation(kind, x);
  found.direction = difference / found.distance;
  return found;
}

bool is_surely_beyond(PairKind kind, const std::array<Vector3, 4>& x, double reach) {
  // A product of a direction and a difference exceeds what is asked for.
  const auto exceeds = [reach](double product, double squared_direction) {
    return product > 0.0 && product * product > (1.0 + 1e-9) * reach * reach * squared_direction;
  };
  if (kind == PairKind::node_node) return (x[0] - x[1]).squaredNorm() > (1.0 + 1e-9) * reach * reach;
  if (kind == PairKind::node_triangle) {
    const Vector3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0], middle = (a + b + c) / 3.0;
    return exceeds(std::min({middle.dot(a), middle.dot(b), middle.dot(c)}), middle.squaredNorm());
  }
  const Vector3 e = x[1] - x[0], f = x[3] - x[2], middle = (x[2] - x[0]) + 0.5 * (f - e);
  const double along = middle.squaredNorm();
  if (exceeds(along - 0.5 * (std::abs(middle.dot(e)) + std::abs(middle.dot(f))), along)) return true;
  // The product of parallel edges is rounding and has any direction.
  const Vector3 normal = e.cross(f);
  return normal.squaredNorm() > nearly_parallel * e.squaredNorm() * f.squaredNorm() &&
         exceeds(std::abs(normal.dot(middle)), normal.squaredNorm());
}

Separation on_side(const Separation& separation, const Vector3& side) {
  if (!(separation.direction.dot(side) < 0.0)) return separation;
  Separation turned = separation;
  turned.distance = -turned.distance;
  turned.direction = -turned.direction;
  return turned;
}

}  // namespace springnet::proximity
