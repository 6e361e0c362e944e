// Distances of nodes, triangles and edges, with what forces need of them: the direction, and the weights of the nodes.
//   gap = distance - thickness,  distance = |d|,  d = sum_i w_i x_i,  d gap / d x_i = w_i n,  n = d / |d|
// The weights are those of the closest points, which depend on the positions as well, but not to first order: the
// distance is stationary in them. Closest points as in C. Ericson, Real-Time Collision Detection (2005), section 5.1.
#pragma once

#include <array>
#include <cstdint>

#include <springnet/network_lists.hpp>

#include "proximity/primitives.hpp"

namespace springnet::proximity {

struct Separation {
  double distance = 0.0;                 // m; >= 0, unless on_side() made it a signed one
  Vector3 direction = Vector3::UnitX();  // unit, from the second primitive's closest point to the first's
  std::array<double, 4> weights{};       // of the nodes: those of the first primitive sum to 1, the second's to -1
};

// The pair's nodes in the order of PairKind, m; unused places are not read. Coordinates must be finite;
// differences beyond 1e70 m, or below 1e-70 m, would leave the range of numbers in products of four. The distance is
// exact to some 1e-15 of the pair's extent, for primitives without area or length too. Where it is 0 to within
// rounding, the direction is that of the triangle's plane, of both edges' common perpendicular or, failing these, one
// that depends on nothing but the corners.
[[nodiscard]] Separation separation(PairKind kind, const std::array<Vector3, 4>& x);

// Nodes of a pair, a bit each, in the order of PairKind: those whose weights are not zero span the feature of each
// primitive that is closest to the other one, a corner, an edge or a face.
using Features = std::uint8_t;
[[nodiscard]] constexpr Features all_features(PairKind kind) noexcept {
  return static_cast<Features>((1u << (first_nodes(kind) + second_nodes(kind))) - 1u);
}
// least: a weight counts from there on.
[[nodiscard]] Features features_of(PairKind kind, const std::array<double, 4>& weights, double least = 0.0);
// As above, but of these features as if they went on beyond their borders, with some weights of the other sign: it
// changes smoothly where closest points leave a feature. Where that is nearly parallel to the other one, or has no
// extent, as above.
[[nodiscard]] Separation separation_between(PairKind kind, const std::array<Vector3, 4>& x, Features features);
// The features that face each other do not determine closest points: edges that are nearly parallel.
[[nodiscard]] bool are_nearly_parallel(PairKind kind, const std::array<Vector3, 4>& x);

// True only if the distance is greater than `reach` (m, >= 0), up to rounding of some 1e-10 of the pair's extent, and
// for most pairs for which it is: a plane across the
// line between the middles of both primitives, or along both edges, is between them. A third of the cost of a distance.
[[nodiscard]] bool is_surely_beyond(PairKind kind, const std::array<Vector3, 4>& x, double reach);

// A surface has two sides, and a distance no sign. `side` is the direction of the pair at the start of the step: while
// the direction stays within a right angle of it, the first primitive has stayed on its side. Beyond, it has gone
// through; the distance is then made negative and the direction reversed, so that gap and gradient continue smoothly.
// A pair that turns by more than a right angle around each other within one step looks the same: take short steps.
[[nodiscard]] Separation on_side(const Separation& separation, const Vector3& side);

}  // namespace springnet::proximity
