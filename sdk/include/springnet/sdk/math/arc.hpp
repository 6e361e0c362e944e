// asin, acos, atan, atan2.
#pragma once

#include <springnet/sdk/math/number.hpp>

namespace springnet::sdk {
namespace detail {

// Their sum: pi / 4.
inline constexpr double quarter_pi = 0x1.921fb54442d18p-1, quarter_pi_rest = 0x1.1a62633145c07p-55;

// asin x = x + x z p(z) with z = x^2 for |x| <= 1/2; p interpolates in the Chebyshev points of [0, 1/4] and changes the
// result by at most 2^-57 of itself. Returns z p(z).
[[nodiscard]] SPRINGNET_INLINE double arc_sine_rest(double z) {
  constexpr double c[] = {0x1.5555555555556p-3, 0x1.3333333332ecap-4, 0x1.6db6db6e31f13p-5, 0x1.f1c71c1db0623p-6,
                          0x1.6e8bb1c8209a2p-6, 0x1.1c4d35cf95421p-6, 0x1.c9cf07674736ap-7, 0x1.782651caa6547p-7,
                          0x1.52420b04b37bep-7, 0x1.65a9c4dfcf8b2p-8, 0x1.1d189408314eep-6, -0x1.e6aaa8a0a04ccp-7,
                          0x1.d72b2bc8155f8p-6};
  return z * polynomial(z, c);
}

}  // namespace detail

// The angle of (x, y) from the x axis, in [-pi, pi], within 2 units in the last place. 0 for (0, 0), whatever the signs
// of the zeros; a zero x counts as positive. nan if an argument is nan or both are infinite. Arguments that are finite
// must be below 2^1022. Cheaper than atan2, which has the specials of C.
//
// With t the tangent of the angle to the nearest multiple of 45 degrees, |t| <= 1/2, and s = t^2:
//   atan t = t + t s p(s), where p interpolates (atan(t) / t - 1) / s in the Chebyshev points of [0, 1/4];
// the polynomial changes the result by at most 0.15 2^-53 of itself. low - high is exact (Sterbenz), so that t has the
// rounding of one division, at most 1 ulp of the result; sums add 0.5 ulp, the rest of the terms less than 0.3.
[[nodiscard]] SPRINGNET_INLINE double plane_angle(double y, double x) {
  const double width = __builtin_fabs(x), height = __builtin_fabs(y);
  const bool steep = height > width;
  const double low = steep ? width : height, high = steep ? height : width;
  const bool diagonal = low > 0.5 * high;
  const double numerator = diagonal ? low - high : low, denominator = diagonal ? low + high : high;
  const double t = numerator / (denominator == 0.0 ? 1.0 : denominator);
  const double s = t * t, s2 = s * s, s4 = s2 * s2;
  const double p0 =
      (-0x1.5555555555554p-2 + 0x1.9999999998dc7p-3 * s) + (-0x1.2492492404d83p-3 + 0x1.c71c7173fae64p-4 * s) * s2;
  const double p4 =
      (-0x1.745d0a99d91e0p-4 + 0x1.3b128bfd32fbbp-4 * s) + (-0x1.110025075dddcp-4 + 0x1.e0955a999ace7p-5 * s) * s2;
  const double p8 =
      (-0x1.a680f4658c711p-5 + 0x1.5ee9281016ed2p-5 * s) + (-0x1.da5fdeb30e33ep-6 + 0x1.6d755fc1636f4p-7 * s) * s2;
  const double curved = t * s * (p0 + s4 * (p4 + s4 * p8));
  // The angle is `quarters` times 45 degrees + sense * atan t.
  const double forward = x < 0.0 ? -1.0 : 1.0;
  const double sense = steep ? -forward : forward;
  const double axis = steep ? 2.0 : 2.0 - 2.0 * forward;
  const double quarters = axis + (diagonal ? sense : 0.0);
  const double angle =
      quarters * detail::quarter_pi + (sense * t + (sense * curved + quarters * detail::quarter_pi_rest));
  return __builtin_copysign(angle, y);
}

// Within 1.7 ulp. Beyond 1/2: asin x = pi/2 - 2 asin(sqrt((1 - x) / 2)).
[[nodiscard]] SPRINGNET_INLINE double asin(double x) {
  using namespace detail;
  const double size = magnitude(x);
  const bool outer = size > 0.5;
  const double z = outer ? 0.5 - 0.5 * size : size * size;
  const double root = outer ? __builtin_sqrt(z) : size;
  const double rest = root * arc_sine_rest(z);
  const double near_one = 2.0 * quarter_pi - (2.0 * root + (2.0 * rest - 2.0 * quarter_pi_rest));
  return with_sign(outer ? near_one : root + rest, x);
}

// Within 1.4 ulp. Within 1/2: acos x = pi/2 - asin x; beyond: 2 asin(sqrt((1 - |x|) / 2)), subtracted from pi for x <
// 0.
[[nodiscard]] SPRINGNET_INLINE double acos(double x) {
  using namespace detail;
  const double size = magnitude(x);
  const bool outer = size > 0.5;
  const double z = outer ? 0.5 - 0.5 * size : size * size;
  const double root = outer ? __builtin_sqrt(z) : x;
  const double rest = root * arc_sine_rest(z);
  const double inner = 2.0 * quarter_pi - (root + (rest - 2.0 * quarter_pi_rest));
  const double right = 2.0 * (root + rest);
  const double left = 4.0 * quarter_pi - (2.0 * root + (2.0 * rest - 4.0 * quarter_pi_rest));
  return outer ? (x < 0.0 ? left : right) : inner;
}

// Within 1.7 ulp; specials as in C.
[[nodiscard]] SPRINGNET_INLINE double atan2(double y, double x) {
  using namespace detail;
  const double width = magnitude(x), height = magnitude(y);
  const bool large = (width < height ? height : width) > 0x1p1000;
  const double scale = large ? 0x1p-100 : 1.0;
  const double bounded_y = height == infinity ? 0x1p1020 : height, bounded_x = width == infinity ? 0x1p1020 : width;
  // Two infinities are as two equal numbers; beside one, all else is as 0. (0, 0) is as (1, 0) or (-1, 0).
  const bool infinite = (width == infinity) | (height == infinity);
  const double b = (infinite & (height != infinity)) ? 0.0 : bounded_y;
  const double a = (infinite & (width != infinity)) ? 0.0 : bounded_x;
  const double result = plane_angle(b * scale, with_sign(b == 0.0 ? 1.0 : a * scale, x));
  return x == x && y == y ? with_sign(result, y) : nan;
}

// Within 1.7 ulp.
[[nodiscard]] SPRINGNET_INLINE double atan(double x) {
  using namespace detail;
  const double bounded = magnitude(x) > 0x1p100 ? 0x1p100 : x;
  return with_sign(plane_angle(bounded, 1.0), x);
}

}  // namespace springnet::sdk
