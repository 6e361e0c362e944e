// log, log1p, log10.
//
// x = 2^k m with m in [1/sqrt 2, sqrt 2), f = m - 1, s = f / (2 + f): log m = 2 atanh s = f - f^2/2 + s (f^2/2 + R),
// R = 2/3 s^2 + 2/5 s^4 + …. R / s^2 is a polynomial in s^2 that interpolates in the Chebyshev points of
// [0, 0.0295] and changes the logarithm by at most 2^-57 of itself. k ln 2 + f is summed with its rounding error.
#pragma once

#include <springnet/sdk/math/exponential.hpp>

namespace springnet::sdk {
namespace detail {

// log(2^k (1 + f) + tail) as a sum of two numbers, the second of them below 1/8 of the first.
[[nodiscard]] SPRINGNET_INLINE Sum logarithm(double k, double f, double tail = 0.0) {
  constexpr double c[] = {0x1.5555555555558p-1, 0x1.99999999952ccp-2, 0x1.2492492df3ba9p-2, 0x1.c71c62e26208bp-3,
                          0x1.7462b58e46ebep-3, 0x1.39fe42e9740a7p-3, 0x1.2b59b713616c9p-3};
  const double s = f / (2.0 + f), square = s * s, half = 0.5 * f * f;
  const double curved = half - s * (half + square * polynomial(square, c));
  const Sum sum = ordered_sum(k * ln_2_high, f);
  return {sum.high, sum.low - (curved - (k * ln_2_low + tail))};
}

// log x for x > 0, `result`; and for all others.
[[nodiscard]] SPRINGNET_INLINE double logarithm_or_special(double x, double result) {
  const double rest = x == 0.0 ? -infinity : nan;
  return x > 0.0 ? (x < infinity ? result : x) : rest;
}

}  // namespace detail

// Within 0.9 ulp.
[[nodiscard]] SPRINGNET_INLINE double log(double x) {
  const detail::Split parts = detail::split(x);
  const detail::Sum sum = detail::logarithm(parts.exponent, parts.fraction - 1.0);
  return detail::logarithm_or_special(x, sum.high + sum.low);
}

// Within 0.7 ulp; exact for powers of 10. The larger parts of the logarithm and of 1 / ln 10 have 26 bits.
[[nodiscard]] SPRINGNET_INLINE double log10(double x) {
  using namespace detail;
  constexpr double log10_e = 0x1.bcb7b1526e50ep-2, log10_e_high = 0x1.bcb7b10000000p-2,
                   log10_e_low = 0x1.49b9438ca9aaep-28;
  const Split parts = split(x);
  const Sum sum = logarithm(parts.exponent, parts.fraction - 1.0);
  const double high = upper(sum.high + sum.low), low = (sum.high - high) + sum.low;
  return logarithm_or_special(x, high * log10_e_high + (high * log10_e_low + low * log10_e));
}

// Within 1.5 ulp. 1 + x and its rounding error are divided by 2^k; the error is added to f and what is lost there to
// the sum.
[[nodiscard]] SPRINGNET_INLINE double log1p(double x) {
  using namespace detail;
  const Sum whole = exact_sum(1.0, x);
  const Split parts = split_normal(whole.high);
  // 2^(1 - k): 2^-k might be subnormal.
  const double scale = from_bits((2047 - parts.exponent_bits) << 52);
  const Sum f = exact_sum(parts.fraction - 1.0, 0.5 * whole.low * scale);
  const Sum sum = logarithm(parts.exponent, f.high, f.low);
  const double result = logarithm_or_special(whole.high, sum.high + sum.low);
  return magnitude(x) < 0x1p-54 ? x : result;
}

}  // namespace springnet::sdk
