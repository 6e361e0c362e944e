// pow, sqrt, cbrt, hypot.
#pragma once

#include <springnet/sdk/math/exponential.hpp>

namespace springnet::sdk {
namespace detail {

// log2 x for x > 0 as a number of 26 bits and a rest; the sum is within 2^-64 of itself.
//
// With s = (m - 1) / (m + 1): 3 atanh(s) / s = 3 + s^2 + s^4 q(s^2), where q interpolates in Chebyshev points. s and
// the sum are split into 26 bits and a rest, so that the product of their larger parts, and that with 2 / (3 ln 2), is
// exact.
[[nodiscard]] SPRINGNET_INLINE Sum split_log2(double x) {
  constexpr double c[] = {0x1.3333333333337p-1, 0x1.b6db6db6d57bbp-2, 0x1.55555561efa1bp-2, 0x1.1745c77345fd1p-2,
                          0x1.d8a515fe52864p-3, 0x1.9824f181b9d1ap-3, 0x1.8cb5c736efc75p-3};
  constexpr double factor = 0x1.ec709dc3a03fdp-1, factor_high = 0x1.ec709d8000000p-1,
                   factor_low = 0x1.0e80ff5d27f05p-27;
  const Split parts = split(x);
  const double m = parts.fraction, f = m - 1.0, inverse = 1.0 / (m + 1.0);
  const double divisor_high = upper(m + 1.0), divisor_low = m - (divisor_high - 1.0);
  const double s_high = upper(f * inverse);
  const double s_low = ((f - s_high * divisor_high) - s_high * divisor_low) * inverse;
  const double square_high = s_high * s_high, square_low = s_low * (s_high + s_high + s_low);
  const double square = square_high + square_low;
  const double curved = square_low + square * square * polynomial(square, c);
  const double sum_high = upper(3.0 + (square_high + curved));
  const double sum_low = (square_high - (sum_high - 3.0)) + curved;
  const double product = s_high * sum_high, product_low = s_low * (sum_high + sum_low) + s_high * sum_low;
  const double high = upper(product + product_low), low = (product - high) + product_low;
  const double log_high = high * factor_high, log_low = high * factor_low + low * factor;
  const double result = upper((log_high + log_low) + parts.exponent);
  return {result, (log_high - (result - parts.exponent)) + log_low};
}

// 2^r for |r| <= 1/2. The polynomial changes it by at most 2^-58 of itself.
[[nodiscard]] SPRINGNET_INLINE double exp2_of_fraction(double r) {
  constexpr double c[] = {0x1.ebfbdff82c58fp-3,  0x1.c6b08d704a0c2p-5,  0x1.3b2ab6fba4e78p-7,  0x1.5d87fe78a526dp-10,
                          0x1.430912f86bf4ep-13, 0x1.ffcbfc6712438p-17, 0x1.62c022401d5c2p-20, 0x1.b524fad88ed30p-24,
                          0x1.e4cf1cc5c8b02p-28, 0x1.e9d419696e0e9p-32, 0x1.c48f8c2305624p-36};
  constexpr double ln_2 = 0x1.62e42fefa39efp-1;
  return 1.0 + (r * ln_2 + r * r * polynomial(r, c));
}
// 2^(high + low), |low| below 1; |high| at most 1100.
[[nodiscard]] SPRINGNET_INLINE double split_exp2(double high, double low) {
  const Rounded k = rounded(high);
  return scaled(exp2_of_fraction((high - k.value) + low), k.bits);
}

}  // namespace detail

[[nodiscard]] SPRINGNET_INLINE double sqrt(double x) { return __builtin_sqrt(x); }

// Within 1.2 ulp; specials as in C. x^y = 2^(y log2 |x|), the product to 2^-53, and the sign. Specials are cases of the
// exponent y log2 |x|: large for x = 0 or infinite, nan for a negative x and a y that is no integer. What depends on y
// alone is arithmetic: in a loop with one y conditions on it would be the same for all elements, and GCC 12 does not
// vectorise selects by such conditions.
[[nodiscard]] SPRINGNET_INLINE double pow(double x, double y) {
  using namespace detail;
  constexpr double large = 0x1p1000;
  const double size = magnitude(x), height = magnitude(y);
  // The distance of y to an even number: 0, 1 for odd numbers, or between them.
  const double near = height > 0x1p53 ? 0x1p53 : height;
  const double distance = magnitude(near - ((near + 0x1p53) - 0x1p53));
  const double odd_is_negative = (2.0 - 2.0 * distance) - 0x1p-60;
  // 0 for integers, else nan; for no y but 0 less than `large`.
  const double fraction = ((distance * (1.0 - distance) * large) * large) * large, real = fraction - fraction;
  const double enlarged = ((y * large) * large) * large;

  const Sum logarithm = split_log2(size);
  const double y_high = upper(y), y_low = y - y_high;
  const double unit = x < 0.0 ? real : 0.0;
  const double any_high = y_high * logarithm.high + unit, any_low = y * logarithm.low + y_low * logarithm.high;
  const double finite_high = size == 1.0 ? unit : any_high, low = size == 1.0 ? 0.0 : any_low;
  const double growth = size > 1.0 ? enlarged : -enlarged;
  const double nonzero_high = size == 0.0 ? growth : finite_high, high = size < infinity ? nonzero_high : growth;
  const double not_large = high > 1100.0 ? 1100.0 : high, in_range = not_large < -1100.0 ? -1100.0 : not_large;
  const double result = split_exp2(in_range, in_range == high ? low : 0.0);
  const double signed_result = from_bits(bits_of(result) ^ (bits_of(x) & bits_of(odd_is_negative) & sign_bit));
  // nan: 1 for y = 0.
  return x == x ? signed_result : 1.0 + (enlarged - enlarged);
}

// x^y in less than half of the time of pow, for normal x > 0: with a relative error of up to 2^-51 (1 + |y log2 x|), as
// the logarithm is rounded to double. Results that are not normal become 0 or infinity.
[[nodiscard]] SPRINGNET_INLINE double quick_pow(double x, double y) {
  using namespace detail;
  // log2((1 + s) / (1 - s)) / s = 2 / ln 2 + s^2 q(s^2); q changes the logarithm by at most 2^-57 of itself.
  constexpr double c[] = {0x1.ec709dc3a0401p-1, 0x1.2776c50ef68ecp-1, 0x1.a61762b5367a7p-2, 0x1.484b091972da2p-2,
                          0x1.0c9e9219bd11dp-2, 0x1.c4ff17011d0fbp-3, 0x1.afdf14af16498p-3};
  const Split parts = split_normal(x);
  const double f = parts.fraction - 1.0, s = f / (2.0 + f), square = s * s;
  const double logarithm = parts.exponent + (0x1.71547652b82fep+1 * s + s * square * polynomial(square, c));
  const double power = y * logarithm, low_bound = power < -1023.0 ? -1023.0 : power;
  const double bounded = low_bound > 1024.0 ? 1024.0 : low_bound;
  const Rounded k = rounded(bounded);
  return exp2_of_fraction(bounded - k.value) * from_bits((k.bits + 1023) << 52);
}

// Within 1.1 ulp. x = 2^3q m with m in [1, 8); a polynomial, which interpolates the root on [1, 2] to 2^-19, times
// 1, 2^1/3 or 2^2/3, then a step of Halley's method.
[[nodiscard]] SPRINGNET_INLINE double cbrt(double x) {
  using namespace detail;
  constexpr double c[] = {0x1.e68ceb1fc3429p-2, 0x1.a9da3cc66f245p-1,  -0x1.d758498b983bcp-2,
                          0x1.92bfc00e33108p-3, -0x1.8bd2dce403128p-5, 0x1.4c7608a04eba1p-8};
  const double size = magnitude(x);
  const bool subnormal = size < 0x1p-1022;
  const std::uint64_t bits = bits_of(subnormal ? size * 0x1p54 : size);
  const double fraction = from_bits((bits & 0x000fffffffffffff) | one_bits);
  // The exponent, biased by a multiple of 3, and a third of it.
  const double exponent = to_double(bits >> 52) + (subnormal ? 1023.0 : 1077.0);
  const Rounded third = rounded(exponent * (1.0 / 3.0) - (1.0 / 3.0));
  const double left = exponent - 3.0 * third.value;
  const double factor = left == 0.0 ? 1.0 : (left == 1.0 ? 2.0 : 4.0);
  const double root_factor = left == 0.0 ? 1.0 : (left == 1.0 ? 0x1.428a2f98d728bp+0 : 0x1.965fea53d6e3dp+0);
  const double m = fraction * factor, first = polynomial(fraction, c) * root_factor;
  const double cube = first * first * first;
  const double root = first + first * (m - cube) / (cube + cube + m);
  // 2^(third - 700): the bias was 1023 + 1077.
  const double result = root * from_bits((third.bits + (1023 - 700)) << 52);
  return size > 0.0 && size < infinity ? with_sign(result, x) : x;
}

// The length of (x, y), within 1.2 ulp; infinite if an argument is, as in C. Arguments are scaled by a power of two so
// that squares neither overflow nor lose bits.
[[nodiscard]] SPRINGNET_INLINE double hypot(double x, double y) {
  using namespace detail;
  const double width = magnitude(x), height = magnitude(y);
  const double larger = width < height ? height : width;
  const double down = larger > 0x1p500 ? 0x1p-600 : 1.0, scale = larger < 0x1p-500 ? 0x1p600 : down;
  const double up = larger > 0x1p500 ? 0x1p600 : 1.0, back = larger < 0x1p-500 ? 0x1p-600 : up;
  const double a = width * scale, b = height * scale;
  const double result = sqrt(a * a + b * b) * back;
  return width == infinity || height == infinity ? infinity : result;
}

}  // namespace springnet::sdk
