// Edges that pass through triangles: surfaces that went through each other, or through themselves. The answer is exact.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "proximity/primitives.hpp"

namespace springnet::proximity {

struct Crossing {
  std::uint32_t edge, triangle;  // of the primitives
  auto operator<=>(const Crossing&) const = default;
};

// An edge crosses a triangle if its ends are on different sides of the plane, neither of them in it, and it passes
// through the triangle or its border. One that only touches, or lies in the plane, does not.
[[nodiscard]] bool crosses(const Vector3& p, const Vector3& q, const Vector3& a, const Vector3& b, const Vector3& c);

// All crossings of edges and triangles that share no node and whose groups are checked against each other, for
// edge_edge or node_triangle, in ascending order. An edge through a border that two triangles share crosses both.
// Throws as PairSearch::find.
[[nodiscard]] std::vector<Crossing> find_crossings(const Primitives& primitives, const Positions& x);

}  // namespace springnet::proximity
