// The values of the invariants of three or four points, in one form for the network's references, the queries and the
// kernels: an element at rest reads its reference to the bit.
#pragma once

#include <springnet/sdk/math.hpp>

namespace springnet::invariants {

// A vector over any number type: gradients are evaluated with doubles, and with duals for their derivatives. All is
// inlined, as kernels require that are compiled for several instruction sets.
template <class T>
struct Triple {
  T x, y, z;
};
template <class T>
SPRINGNET_INLINE Triple<T> operator+(const Triple<T>& a, const Triple<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
SPRINGNET_INLINE Triple<T> operator-(const Triple<T>& a, const Triple<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
SPRINGNET_INLINE Triple<T> operator-(const Triple<T>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class T>
SPRINGNET_INLINE Triple<T> operator*(const T& s, const Triple<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
SPRINGNET_INLINE T dot(const Triple<T>& a, const Triple<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
SPRINGNET_INLINE Triple<T> cross(const Triple<T>& a, const Triple<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
SPRINGNET_INLINE double root(double x) { return __builtin_sqrt(x); }

using Point = Triple<double>;  // m

// m
SPRINGNET_INLINE double length(const Point& a, const Point& b) { return root(dot(a - b, a - b)); }

// Of the corner b, in rad, between 0 and pi.
SPRINGNET_INLINE double angle(const Point& a, const Point& b, const Point& c) {
  const Point u = a - b, w = c - b, n = cross(u, w);
  return sdk::plane_angle(root(dot(n, n)), dot(u, w));
}
// Between the normals of the triangles (a, b, c) and (b, a, d), in rad, between -pi and pi: 0 where flat, positive
// where the tips turn away from the side to which the normals point. With the edge e = b - a and the normals m = e x (c
// - a), n = (d - a) x e the sine is (m x n) . e / |e| = -|e| m . (d - a), both times |m| |n|.
SPRINGNET_INLINE double dihedral(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point e = b - a, to_d = d - a, m = cross(e, c - a), n = cross(to_d, e);
  return sdk::plane_angle(-(root(dot(e, e)) * dot(m, to_d)), dot(m, n));
}
// m^2
SPRINGNET_INLINE double area(const Point& a, const Point& b, const Point& c) {
  const Point n = cross(b - a, c - a);
  return 0.5 * root(dot(n, n));
}
// m^3, signed
SPRINGNET_INLINE double volume(const Point& a, const Point& b, const Point& c, const Point& d) {
  return dot(b - a, cross(c - a, d - a)) / 6.0;
}

}  // namespace springnet::invariants
