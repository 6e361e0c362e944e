#include "constraints/pair_features.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace springnet {

bool is_said_by_touching(const BodyContacts& bodies, proximity::PairKind kind, proximity::Pair pair,
                         const std::array<double, 4>& weights, const proximity::Positions& x) {
  return is_said_by_another(bodies, kind, pair, proximity::features_of(kind, weights, least_weight), x,
                            [&](proximity::PairKind of, proximity::Pair other) { return bodies.touches(of, other); });
}

proximity::Features features_towards(const BodyContacts& bodies, const PairTouch& touch,
                                     const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                                     std::size_t node_count) {
  constexpr double ahead = 1e-7;  // of the pair's extent
  const proximity::Primitives& all = bodies.primitives();
  std::array<Vector3, 4> x = all.corners(touch.kind, touch.pair, positions_of(position, node_count));
  const std::array<NodeIndex, 4> nodes = all.nodes_of(touch.kind, touch.pair);
  const proximity::Features now = features_of(touch.kind, separation(touch.kind, x).weights, least_weight);
  double extent = 0.0, speed = 0.0;
  const Vector3 common = vector_at(velocity, nodes[0]);
  for (std::size_t i = 1; i < 4; ++i) {
    extent = std::max(extent, (x[i] - x[0]).norm());
    speed = std::max(speed, (vector_at(velocity, nodes[i]) - common).norm());
  }
  if (!(speed > 0.0)) return now;
  const double time = ahead * extent / speed;  // s
  for (std::size_t i = 0; i < 4; ++i) x[i] += time * (vector_at(velocity, nodes[i]) - common);
  const proximity::Features then = features_of(touch.kind, separation(touch.kind, x).weights, least_weight);
  return static_cast<proximity::Features>(now | then);
}

proximity::Features groove_between(const BodyContacts& bodies, proximity::Pair pair, proximity::Pair other,
                                   const proximity::Positions& x, double tolerance) {
  constexpr proximity::PairKind kind = proximity::PairKind::node_triangle;
  const proximity::Primitives& all = bodies.primitives();
  const std::array<NodeIndex, 4> nodes = all.nodes_of(kind, pair), others = all.nodes_of(kind, other);
  const std::array<Vector3, 4> corners = all.corners(kind, pair, x);
  const proximity::Separation first = separation(kind, corners), second = separation(kind, all.corners(kind, other, x));
  bool leaves_first = false, leaves_second = false;
  unsigned shared = 1u;
  for (std::size_t i = 1; i < 4; ++i) {
    if (std::find(others.begin() + 1, others.end(), nodes[i]) != others.end())
      shared |= 1u << i;
    else
      leaves_first = leaves_first || std::abs(first.weights[i]) > least_weight;
    if (std::find(nodes.begin() + 1, nodes.end(), others[i]) == nodes.end())
      leaves_second = leaves_second || std::abs(second.weights[i]) > least_weight;
  }
  auto features = static_cast<proximity::Features>(shared);
  if (std::popcount(shared) != 3 || !leaves_first || !leaves_second || !bodies.touch_alike(kind, pair, kind, other))
    return 0;
  // Of an edge, the end only if that is nearest.
  proximity::Separation at = separation_between(kind, corners, features);
  for (std::size_t i = 1; i < 4; ++i)
    if ((features >> i & 1u) != 0 && -at.weights[i] <= least_weight)
      features = static_cast<proximity::Features>(features & ~(1u << i));
  at = separation_between(kind, corners, features);
  return at.distance - std::min(first.distance, second.distance) <= tolerance ? features : proximity::Features{0};
}

SideBySide side_by_side(proximity::PairKind kind, const std::array<Vector3, 4>& corners) {
  SideBySide result;
  if (!are_nearly_parallel(kind, corners)) return result;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const unsigned other = corner < 2 ? 0b1100u : 0b0011u;
    const proximity::Separation at =
        separation_between(kind, corners, static_cast<proximity::Features>(1u << corner | other));
    bool is_beside = true;
    for (std::size_t i = 0; i < 4; ++i) is_beside = is_beside && (i < 2 ? at.weights[i] : -at.weights[i]) >= 0.0;
    if (!is_beside) continue;
    result.ends[result.count++] = features_of(kind, at.weights, least_weight);
    result.farthest = std::max(result.farthest, at.distance);
  }
  return result;
}

double before_side_by_side(proximity::PairKind kind, const std::array<Vector3, 4>& corners, double tolerance) {
  const SideBySide ends = side_by_side(kind, corners);
  if (ends.count < 2) return 1.0;
  return (ends.farthest - separation(kind, corners).distance) / tolerance - 1.0;
}

double gradient_difference(const PairMotion& a, const PairMotion& b) {
  double sum = 0.0;
  bool have_any = false;
  std::array<bool, 4> of_b{};  // of nodes of b: a has them, too
  for (std::size_t i = 0; i < a.count; ++i) {
    Vector3 difference = a.weights[i] * a.normal;
    for (std::size_t j = 0; j < b.count; ++j)
      if (a.nodes[i] == b.nodes[j]) {
        difference -= b.weights[j] * b.normal;
        have_any = of_b[j] = true;
      }
    sum += difference.squaredNorm();
  }
  if (!have_any) return 2.0;
  for (std::size_t j = 0; j < b.count; ++j)
    if (!of_b[j]) sum += b.weights[j] * b.weights[j];
  return std::sqrt(sum);
}

double before_same(const PairMotion& a, const PairMotion& b, double tolerance) {
  return std::max(gradient_difference(a, b) - same_of_touching, std::abs(a.gap - b.gap) / tolerance - 1.0);
}

double before_border(const BodyContacts& bodies, const PairTouch& touch, const PairMotion& motion,
                     const proximity::Positions& x, double tolerance) {
  const auto firsts = static_cast<std::size_t>(proximity::first_nodes(touch.kind));
  const auto is_of = [&](std::size_t i) { return (touch.between >> i & 1u) != 0; };
  double least = 1.0;
  for (std::size_t i = 0; i < motion.count; ++i)
    if (is_of(i)) least = std::min(least, i < firsts ? motion.weights[i] : -motion.weights[i]);
  double result = least + feature_border;
  if (touch.between == proximity::all_features(touch.kind)) return result;
  // Others that share the features, and itself, of which a closest point leaves these.
  const proximity::Primitives& all = bodies.primitives();
  const auto is_on_features = [&](NodeIndex node) {
    for (std::size_t i = 0; i < motion.count; ++i)
      if (is_of(i) && motion.nodes[i] == node) return true;
    return false;
  };
  struct Over {
    proximity::Pair pair;
    double before, gap;
  };
  std::vector<Over> faces;  // that a node has come over
  bodies.shared().for_each_pair_at(
      touch.kind, touch.pair, touch.between, [&](proximity::PairKind of, proximity::Pair other) {
        const bool is_itself = of == touch.kind && other == touch.pair;
        if (!is_itself && (bodies.touches(of, other) || !bodies.touch_alike(touch.kind, touch.pair, of, other))) return;
        const std::array<Vector3, 4> corners = all.corners(of, other, x);
        if (are_nearly_parallel(of, corners)) return;
        const proximity::Separation at = separation(of, corners);
        const std::array<NodeIndex, 4> nodes = all.nodes_of(of, other);
        const auto count = static_cast<std::size_t>(proximity::first_nodes(of)) +
                           static_cast<std::size_t>(proximity::second_nodes(of));
        double before = 2.0 * feature_border;
        for (std::size_t i = 0; i < count; ++i)
          if (!is_on_features(nodes[i])) before = std::min(before, 2.0 * feature_border - std::abs(at.weights[i]));
        if (of == proximity::PairKind::node_triangle && before < feature_border)
          faces.push_back({other, before, at.distance - all.thickness(of, other)});
        else
          result = std::min(result, before);
      });
  for (const Over& face : faces) {
    const bool in_groove = std::any_of(faces.begin(), faces.end(), [&](const Over& other) {
      return other.pair != face.pair && other.pair.first == face.pair.first &&
             groove_between(bodies, face.pair, other.pair, x, std::numeric_limits<double>::infinity()) != 0;
    });
    // In a groove it leaves when that becomes too deep.
    result = std::min(result, in_groove ? feature_border * (1.0 + (face.gap - motion.gap) / tolerance) : face.before);
  }
  return result;
}

}  // namespace springnet
