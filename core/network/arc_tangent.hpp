// The angle of a vector in the plane, without branches and without the C library: loops over it vectorise, and it has
// the same bits on every processor.
#pragma once

#include <springnet/sdk/dual.hpp>  // SPRINGNET_INLINE

namespace springnet {

// The angle of (x, y) from the x axis, in [-pi, pi], within 2 units in the last place. 0 for (0, 0), whatever the signs
// of the zeros; a zero x counts as positive. nan if an argument is nan or both are infinite. Arguments that are finite
// must be below 2^1022.
//
// With t the tangent of the angle to the nearest multiple of 45 degrees, |t| <= 1/2, and s = t^2:
//   atan t = t + t s p(s), where p interpolates (atan(t) / t - 1) / s in the Chebyshev points of [0, 1/4];
// the polynomial changes the result by at most 0.15 2^-53 of itself. low - high is exact (Sterbenz), so that t has the
// rounding of one division, at most 1 ulp of the result; sums add 0.5 ulp, the rest of the terms less than 0.3.
SPRINGNET_INLINE double arc_tangent(double y, double x) {
  constexpr double quarter = 0x1.921fb54442d18p-1, quarter_rest = 0x1.1a62633145c07p-55;  // their sum: pi / 4
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
  const double angle = quarters * quarter + (sense * t + (sense * curved + quarters * quarter_rest));
  return __builtin_copysign(angle, y);
}

}  // namespace springnet
