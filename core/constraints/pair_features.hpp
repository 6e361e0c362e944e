// Between which corners, edges and faces pairs touch while events are located. Pairs whose primitives share these touch
// at the same place: the one whose closest points are within its faces and edges says what all of them do, and the
// others are left out until it leaves these at a border.
#pragma once

#include "constraints/body_contacts.hpp"
#include "constraints/pair_motion.hpp"

namespace springnet {

// Share of an edge by which a closest point has left a feature, or is on one.
inline constexpr double feature_border = 1e-9;
inline constexpr double least_weight = 0.1 * feature_border;

// Whether another pair says what one that touches between these features does: with the same law and thickness, and
// said(kind, pair).
template <class Said>
[[nodiscard]] bool is_said_by_another(const BodyContacts& bodies, proximity::PairKind kind, proximity::Pair pair,
                                      proximity::Features features, const proximity::Positions& x, const Said& said) {
  if (features == proximity::all_features(kind)) return false;
  const proximity::Primitives& all = bodies.primitives();
  bool found = false;
  bodies.shared().for_each_pair_at(kind, pair, features, [&](proximity::PairKind of, proximity::Pair other) {
    found = found || ((of != kind || other != pair) && bodies.touch_alike(kind, pair, of, other) &&
                      !are_nearly_parallel(of, all.corners(of, other, x)) && said(of, other));
  });
  return found;
}
// By one that touches at the committed state.
[[nodiscard]] bool is_said_by_touching(const BodyContacts& bodies, proximity::PairKind kind, proximity::Pair pair,
                                       const std::array<double, 4>& weights, const proximity::Positions& x);

// The features between which a pair is closest, with those that it is moving onto: from a corner onto a face.
[[nodiscard]] proximity::Features features_towards(const BodyContacts& bodies, const PairTouch& touch,
                                                   const springnet_const_vectors& position,
                                                   const springnet_const_vectors& velocity, std::size_t node_count);

// A node over an edge where two faces fold towards it, so little that it is on both and on the edge to within a
// tolerance (m): that alone is what it touches, or else friction on both, at nearly the same place, would hold the
// fold. The node and what it is over, of the first face; 0: it is in no such groove.
[[nodiscard]] proximity::Features groove_between(const BodyContacts& bodies, proximity::Pair pair,
                                                 proximity::Pair other, const proximity::Positions& x,
                                                 double tolerance);

// How far a pair that touches is from leaving its features, to be left out for another one or to touch between others;
// below 0 it has. In shares of an edge, `feature_border` more than it is. tolerance: m, of gaps.
[[nodiscard]] double before_border(const BodyContacts& bodies, const PairTouch& touch, const PairMotion& motion,
                                   const proximity::Positions& x, double tolerance);

// Where edges that are nearly parallel, and touch in between, begin and end to lie side by side.
struct SideBySide {
  std::array<proximity::Features, 4> ends{};  // a corner of one, and what it is beside of the other
  std::size_t count = 0;                      // of these; 0: they do not
  double farthest = 0.0;                      // m, distance at an end
};
[[nodiscard]] SideBySide side_by_side(proximity::PairKind kind, const std::array<Vector3, 4>& corners);
// Below 0: at these ends, too, they are as close as in between, and the direction between them is that of its rounding.
// tolerance: m, of gaps. 1 for all other pairs.
[[nodiscard]] double before_side_by_side(proximity::PairKind kind, const std::array<Vector3, 4>& corners,
                                         double tolerance);

// How much the gaps of two pairs differ in how they change with positions: the norm of the difference of their
// gradients, whose parts are at most 1; 2 where they have no node in common.
[[nodiscard]] double gradient_difference(const PairMotion& a, const PairMotion& b);
// Two pairs that run towards a border that they share, such as a corner over a face and the edges that cross beside it,
// change with positions in the same way there. From this difference on they are one; those that touch already from a
// smaller one on.
inline constexpr double nearly_same = 1e-4, same_of_touching = 1e-5;
// Below 0: the two are one, of pairs that touch. tolerance: m, of gaps.
[[nodiscard]] double before_same(const PairMotion& a, const PairMotion& b, double tolerance);

}  // namespace springnet
