// On which side of a plane a point is, exactly: the sign of a determinant, whatever the rounding.
#pragma once

#include <springnet/network_lists.hpp>

namespace springnet::proximity {

// Sign of the volume (b - a) x (c - a) . (d - a): 1, 0 or -1. Rounded arithmetic decides if its error bound allows
// (J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, 1997), rational
// numbers otherwise. Coordinates must be finite.
[[nodiscard]] int orientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d);

}  // namespace springnet::proximity
