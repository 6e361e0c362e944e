// Pairs that others imply: those whose gaps change alike, and edges side by side.

#include "constraints/pair_features.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace springnet;

namespace {

// A corner over a face, beside one of its edges by this share of the way to the third corner; and an edge from that
// corner, which crosses the edge of the face at this share of its length.
PairMotion corner_on_face(double share) {
  PairMotion pair;
  pair.kind = proximity::PairKind::node_triangle;
  pair.nodes = {0, 1, 2, 3};
  pair.weights = {1.0, -0.5, -0.5 + share, -share};
  pair.count = 4;
  pair.normal = Vector3::UnitZ();
  return pair;
}
PairMotion edge_on_edge(double share) {
  PairMotion pair;
  pair.kind = proximity::PairKind::edge_edge;
  pair.nodes = {0, 4, 1, 2};
  pair.weights = {1.0 - share, share, -0.5, -0.5};
  pair.count = 4;
  pair.normal = Vector3::UnitZ();
  return pair;
}

std::array<Vector3, 4> beside(double shift, double height, double raised, double turned) {
  const Vector3 from(shift, 0, height);
  return {Vector3(0, 0, 0), Vector3(1, 0, 0), from, from + Vector3(std::cos(turned), std::sin(turned), raised)};
}

}  // namespace

TEST_CASE("gaps of pairs that run towards their common border change alike") {
  for (const double share : {0.3, 1e-3, 1e-6}) {
    const PairMotion face = corner_on_face(share);
    PairMotion edges = edge_on_edge(share);
    // Four weights differ by the share.
    CHECK(gradient_difference(face, edges) == doctest::Approx(2.0 * share).epsilon(1e-9));
    CHECK(gradient_difference(edges, face) == doctest::Approx(2.0 * share).epsilon(1e-9));
    // Which primitive is the first changes nothing.
    edges.nodes = {1, 2, 0, 4};
    edges.weights = {0.5, 0.5, share - 1.0, -share};
    edges.normal = -edges.normal;
    CHECK(gradient_difference(face, edges) == doctest::Approx(2.0 * share).epsilon(1e-9));
    // Directions count as well: weights of 1 and twice 1 / 2 turn by an angle.
    edges = edge_on_edge(0.0);
    edges.normal = Vector3(std::sin(share), 0, std::cos(share));
    CHECK(gradient_difference(corner_on_face(0.0), edges) ==
          doctest::Approx(2.0 * std::sin(0.5 * share) * std::sqrt(1.5)).epsilon(1e-9));
  }
  PairMotion elsewhere = edge_on_edge(0.1);
  elsewhere.nodes = {5, 6, 7, 8};
  CHECK(gradient_difference(corner_on_face(0.1), elsewhere) == 2.0);
}

TEST_CASE("pairs that touch are the same where gradients and gaps agree") {
  const double tolerance = 1e-8;
  PairMotion face = corner_on_face(1e-6), edges = edge_on_edge(1e-6);
  CHECK(before_same(face, edges, tolerance) < 0.0);
  edges.gap = 2.0 * tolerance;
  CHECK(before_same(face, edges, tolerance) > 0.0);
  edges = edge_on_edge(1e-4);
  CHECK(before_same(face, edges, tolerance) > 0.0);
}

TEST_CASE("edges lie side by side from a corner of one to a corner of the other") {
  constexpr proximity::PairKind edges = proximity::PairKind::edge_edge;
  const double tolerance = 1e-9;
  const SideBySide ends = side_by_side(edges, beside(0.3, 0.01, 0.0, 0.0));
  REQUIRE(ends.count == 2);
  CHECK(ends.ends[0] == 0b1110);                   // the end of the first over the second
  CHECK(ends.ends[1] == 0b0111);                   // the start of the second over the first
  CHECK(std::abs(ends.farthest - 0.01) <= 1e-14);  // of a few sums of numbers of order 1
  CHECK(before_side_by_side(edges, beside(0.3, 0.01, 0.0, 0.0), tolerance) < 0.0);
  // Exactly above each other: corners on corners.
  const SideBySide above = side_by_side(edges, beside(0.0, 0.01, 0.0, 0.0));
  REQUIRE(above.count == 4);
  CHECK(above.ends[0] == 0b0101);
  CHECK(above.ends[1] == 0b1010);
  // Farther at one end: the other one alone is closest. Turned: they cross, or end beside each other.
  CHECK(before_side_by_side(edges, beside(0.3, 0.01, 1e-7, 0.0), tolerance) > 0.0);
  CHECK(side_by_side(edges, beside(0.3, 0.01, 0.0, 0.1)).count == 0);
  CHECK(before_side_by_side(edges, beside(0.3, 0.01, 0.0, 0.1), tolerance) == 1.0);
  CHECK(before_side_by_side(edges, beside(2.0, 0.01, 0.0, 0.0), tolerance) == 1.0);
}
