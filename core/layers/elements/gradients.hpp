// Gradients of the invariants of three or four points, zero where they are undefined. Without branches, so that loops
// over them vectorise.
#pragma once

#include <cstdint>

#include <springnet/sdk/dual.hpp>

#include "layers/elements/scalars.hpp"
#include "network/invariant_values.hpp"

namespace springnet::layers {

using invariants::cross;
using invariants::dot;
using invariants::Point;
using invariants::root;
using invariants::Triple;
using sdk::value_of;

// 1 / x, or 0 unless `defined`.
SPRINGNET_INLINE double inverse_if(bool defined, double x) { return defined ? 1.0 / (defined ? x : 1.0) : 0.0; }
template <std::size_t N>
SPRINGNET_INLINE sdk::Dual<N> inverse_if(bool defined, const sdk::Dual<N>& x) {
  return defined ? 1.0 / x : sdk::Dual<N>(0.0);
}
template <std::size_t N>
SPRINGNET_INLINE sdk::Dual<N> root(const sdk::Dual<N>& x) {
  return sqrt(x);
}

// u = a - b, w = c - b, n = u x w: dq/da = u x n / (|u|^2 |n|), dq/dc = n x w / (|w|^2 |n|).
template <class T>
SPRINGNET_INLINE void angle_gradients(const Triple<T>& a, const Triple<T>& b, const Triple<T>& c, Triple<T>& by_a,
                                      Triple<T>& by_b, Triple<T>& by_c) {
  const Triple<T> u = a - b, w = c - b, n = cross(u, w);
  const T square = dot(n, n);
  const bool defined = value_of(square) > 0.0;
  const T size = root(defined ? square : T(1.0));
  by_a = inverse_if(defined, dot(u, u) * size) * cross(u, n);
  by_c = inverse_if(defined, dot(w, w) * size) * cross(n, w);
  by_b = -(by_a + by_c);
}

// e = b - a, normals m = e x (c - a), n = (d - a) x e: dq/dc = -|e| m / |m|^2, dq/dd = -|e| n / |n|^2. The ends
// of the edge balance the tips by the lever rule at the feet of the tips on the edge.
template <class T>
SPRINGNET_INLINE void dihedral_gradients(const Triple<T>& a, const Triple<T>& b, const Triple<T>& c, const Triple<T>& d,
                                         Triple<T>& by_a, Triple<T>& by_b, Triple<T>& by_c, Triple<T>& by_d) {
  const Triple<T> e = b - a, to_c = c - a, to_d = d - a, m = cross(e, to_c), n = cross(to_d, e);
  const T ee = dot(e, e), mm = dot(m, m), nn = dot(n, n);
  const bool defined = value_of(mm) > 0.0 && value_of(nn) > 0.0;
  const T length = root(defined ? ee : T(1.0)), per_square = inverse_if(defined, ee);
  by_c = (-(length * inverse_if(defined, mm))) * m;
  by_d = (-(length * inverse_if(defined, nn))) * n;
  const T at_c = dot(to_c, e) * per_square, at_d = dot(to_d, e) * per_square;
  by_b = -(at_c * by_c + at_d * by_d);
  by_a = -(by_b + by_c + by_d);
}

// dq/da = n x (c - b) / 2 with the unit normal n, and cyclically.
template <class T>
SPRINGNET_INLINE void area_gradients(const Triple<T>& a, const Triple<T>& b, const Triple<T>& c, Triple<T>& by_a,
                                     Triple<T>& by_b, Triple<T>& by_c) {
  const Triple<T> to_b = b - a, to_c = c - a, n = cross(to_b, to_c);
  const T square = dot(n, n);
  const bool defined = value_of(square) > 0.0;
  const Triple<T> half = (0.5 * inverse_if(defined, root(defined ? square : T(1.0)))) * n;
  by_b = cross(to_c, half);
  by_c = cross(half, to_b);
  by_a = -(by_b + by_c);
}

template <class T>
SPRINGNET_INLINE void volume_gradients(const Triple<T>& a, const Triple<T>& b, const Triple<T>& c, const Triple<T>& d,
                                       Triple<T>& by_a, Triple<T>& by_b, Triple<T>& by_c, Triple<T>& by_d) {
  const Triple<T> to_b = b - a, to_c = c - a, to_d = d - a;
  const T sixth(1.0 / 6.0);
  by_b = sixth * cross(to_c, to_d);
  by_c = sixth * cross(to_d, to_b);
  by_d = sixth * cross(to_b, to_c);
  by_a = -(by_b + by_c + by_d);
}

// dq/dp of the corners; d is neither read nor written for three points.
template <Measure measure, class T>
SPRINGNET_INLINE void gradients(const Triple<T>& a, const Triple<T>& b, const Triple<T>& c, const Triple<T>& d,
                                Triple<T>& by_a, Triple<T>& by_b, Triple<T>& by_c, Triple<T>& by_d) {
  if constexpr (measure == Measure::angle) angle_gradients(a, b, c, by_a, by_b, by_c);
  if constexpr (measure == Measure::dihedral) dihedral_gradients(a, b, c, d, by_a, by_b, by_c, by_d);
  if constexpr (measure == Measure::area) area_gradients(a, b, c, by_a, by_b, by_c);
  if constexpr (measure == Measure::volume) volume_gradients(a, b, c, d, by_a, by_b, by_c, by_d);
}

template <Measure measure>
SPRINGNET_INLINE double value_at(const Point& a, const Point& b, const Point& c, const Point& d) {
  if constexpr (measure == Measure::angle) return invariants::angle(a, b, c);
  if constexpr (measure == Measure::dihedral) return invariants::dihedral(a, b, c, d);
  if constexpr (measure == Measure::area) return invariants::area(a, b, c);
  if constexpr (measure == Measure::volume) return invariants::volume(a, b, c, d);
  return 0.0;
}

// The value that laws read: a dihedral angle is shifted by whole turns to be nearest to its reference, so that it jumps
// half a turn away from rest, not where wings that rest folded pass through one another.
SPRINGNET_INLINE double turned(double value, double reference) {
  constexpr double turn = 0x1.921fb54442d18p+2, per_turn = 0x1.45f306dc9c883p-3;  // 2 pi and its inverse
  constexpr double to_integer = 0x1.8p52;  // added and subtracted: rounds to an integer
  return value + turn * ((reference - value) * per_turn + to_integer - to_integer);
}

}  // namespace springnet::layers
