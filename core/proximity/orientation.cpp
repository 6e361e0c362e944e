#include "proximity/orientation.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include <boost/multiprecision/cpp_int.hpp>

namespace springnet::proximity {

namespace {

using Rational = boost::multiprecision::cpp_rational;
using RationalVector = std::array<Rational, 3>;

RationalVector exact_difference(const Vector3& a, const Vector3& b) {
  return {Rational(a.x()) - Rational(b.x()), Rational(a.y()) - Rational(b.y()), Rational(a.z()) - Rational(b.z())};
}

int exact_orientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const RationalVector u = exact_difference(b, a), v = exact_difference(c, a), w = exact_difference(d, a);
  const Rational volume =
      w[0] * (u[1] * v[2] - u[2] * v[1]) + w[1] * (u[2] * v[0] - u[0] * v[2]) + w[2] * (u[0] * v[1] - u[1] * v[0]);
  return volume.sign();
}

}  // namespace

int orientation(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const auto same = [&](int k) { return a[k] == b[k] && a[k] == c[k] && a[k] == d[k]; };
  if (same(0) || same(1) || same(2)) return 0;  // flat nets need no rational numbers
  const Vector3 u = b - a, v = c - a, w = d - a;
  const double xy = u.x() * v.y(), yx = u.y() * v.x(), yz = u.y() * v.z(), zy = u.z() * v.y(), zx = u.z() * v.x(),
               xz = u.x() * v.z();
  const double volume = w.x() * (yz - zy) + w.y() * (zx - xz) + w.z() * (xy - yx);
  const double size = std::abs(w.x()) * (std::abs(yz) + std::abs(zy)) +
                      std::abs(w.y()) * (std::abs(zx) + std::abs(xz)) + std::abs(w.z()) * (std::abs(xy) + std::abs(yx));
  // Each term is rounded by eight roundings at most: of three differences, two products, three sums. The smallest
  // numbers, whose products vanish, are left to rational numbers.
  const double bound = 0x1p-49 * size;
  if (size > 1e-250 && size < 1e300) {
    if (volume > bound) return 1;
    if (volume < -bound) return -1;
  }
  return exact_orientation(a, b, c, d);
}

}  // namespace springnet::proximity
