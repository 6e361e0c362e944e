// exp, expm1, sinh, cosh, tanh.
//
// With k = x / ln 2 rounded to an integer and r = x - k ln 2, |r| <= 0.3466: e^x = 2^k e^r. ln 2 is the sum of a part
// of 42 bits, whose product with k is exact, and a rest; r is kept with the error of its rounding. e^r comes from a
// polynomial, which interpolates in the Chebyshev points of the interval.
#pragma once

#include <springnet/sdk/math/number.hpp>

namespace springnet::sdk {
namespace detail {

inline constexpr double log2_e = 0x1.71547652b82fep+0;
inline constexpr double ln_2_high = 0x1.62e42fefa3800p-1, ln_2_low = 0x1.ef35793c76730p-45;

// x = k ln 2 + r + rest.
struct ReducedExponent {
  Rounded k;
  double r, rest;
};
[[nodiscard]] SPRINGNET_INLINE ReducedExponent reduced_exponent(double x) {
  const Rounded k = rounded(x * log2_e);
  const double high = x - k.value * ln_2_high, low = k.value * ln_2_low;
  const double r = high - low;
  return {k, r, (high - r) - low};
}

// e^r - 1 = r + returned value. Changes e^r by at most 2^-61 of itself.
[[nodiscard]] SPRINGNET_INLINE double exponential_rest(double r, double rest) {
  constexpr double c[] = {0x1.0000000000000p-1,  0x1.5555555555557p-3,  0x1.5555555555556p-5,  0x1.11111111100dcp-7,
                          0x1.6c16c16c162d4p-10, 0x1.a01a01abe7fe1p-13, 0x1.a01a01a6d889cp-16, 0x1.71de0231960ebp-19,
                          0x1.27e4db646b17ep-22, 0x1.af4de97ca4194p-26, 0x1.1f730349868cep-29};
  return rest + r * r * polynomial(r, c);
}

// e^x 2^shift. x between -746 and 746: 2^k is a product of two factors, which are finite.
[[nodiscard]] SPRINGNET_INLINE double scaled_exp(double x, std::uint64_t shift) {
  const ReducedExponent e = reduced_exponent(x);
  return scaled(1.0 + (e.r + exponential_rest(e.r, e.rest)), e.k.bits + shift);
}

}  // namespace detail

// Within 0.9 ulp.
[[nodiscard]] SPRINGNET_INLINE double exp(double x) {
  const double bounded = detail::magnitude(x) > 746.0 ? detail::with_sign(746.0, x) : x;
  return detail::scaled_exp(bounded, 0);
}

namespace detail {
struct ExponentialPair {
  double less_1, value;  // e^x - 1 and e^x
};
// Half of e^x - 1, so that 2^k stays finite, is (2^k - 1) / 2 + 2^k (e^r - 1) / 2; both sums keep their rounding
// errors.
[[nodiscard]] SPRINGNET_INLINE ExponentialPair expm1_and_exp(double x) {
  constexpr double c[] = {0x1.5555555555556p-3,  0x1.5555555555555p-5,  0x1.11111111109b3p-7,  0x1.6c16c16c167e1p-10,
                          0x1.a01a01a7c41d5p-13, 0x1.a01a01a47b054p-16, 0x1.71de0dae63bb3p-19, 0x1.27e4e1f48534fp-22,
                          0x1.af38a9b0ec855p-26, 0x1.1f66df7fca49fp-29};
  const double bounded = magnitude(x + 18.0) > 728.0 ? with_sign(728.0, x) - 18.0 : x;  // between -746 and 710
  const ReducedExponent e = reduced_exponent(bounded);
  const double square = e.r * e.r;
  const double curved = e.rest + (0.5 * square + e.r * square * polynomial(e.r, c));
  // Below -700 the result is -1, and 2^k / 2 may not be a normal number.
  const double scale = bounded < -700.0 ? 0.0 : from_bits((e.k.bits + 1022) << 52);
  const Sum power = ordered_sum(scale, -0.5);
  const Sum sum = ordered_sum(power.high, scale * e.r);
  const double result = 2.0 * (sum.high + ((sum.low + power.low) + scale * curved));
  return {magnitude(x) < 0x1p-54 ? x : result, scaled(1.0 + (e.r + curved), e.k.bits)};
}
}  // namespace detail

// Within 0.95 ulp.
[[nodiscard]] SPRINGNET_INLINE double expm1(double x) { return detail::expm1_and_exp(x).less_1; }

// Within 1.7 ulp. Below 1 an odd polynomial, which changes the result by at most 2^-56 of itself; above, e^-x is
// computed as 1 / e^x.
[[nodiscard]] SPRINGNET_INLINE double sinh(double x) {
  using namespace detail;
  constexpr double c[] = {0x1.5555555555555p-3,  0x1.1111111111111p-7,  0x1.a01a01a01a001p-13, 0x1.71de3a556f96cp-19,
                          0x1.ae6456792a77fp-26, 0x1.612467ccb2260p-33, 0x1.ae777c36fd5b6p-41, 0x1.99f0806c2628dp-49};
  const double size = magnitude(x), square = x * x;
  const double half = scaled_exp(size > 711.0 ? 711.0 : size, static_cast<std::uint64_t>(-1));
  const double large = half - 0.25 / half;
  const double small = size + size * square * polynomial(square, c);
  return with_sign(size < 1.0 ? small : large, x);
}

// Within 1.4 ulp.
[[nodiscard]] SPRINGNET_INLINE double cosh(double x) {
  const double size = detail::magnitude(x);
  const double half = detail::scaled_exp(size > 711.0 ? 711.0 : size, static_cast<std::uint64_t>(-1));
  return half + 0.25 / half;
}

// Within 1.5 ulp. Below 0.55 an odd polynomial, which changes the result by at most 2^-57 of itself; above,
// 1 - 2 / (e^2x + 1).
[[nodiscard]] SPRINGNET_INLINE double tanh(double x) {
  using namespace detail;
  constexpr double c[] = {-0x1.5555555555555p-2,  0x1.1111111110fd9p-3,  -0x1.ba1ba1b9f49e6p-5,  0x1.664f487384560p-6,
                          -0x1.226e324ef7265p-7,  0x1.d6d318a012c9ep-9,  -0x1.7d95d08f04614p-10, 0x1.34b253ea057a5p-11,
                          -0x1.eb2f1f90d81f4p-13, 0x1.6227bf9d410dep-14, -0x1.51eb0f790fd4bp-16};
  const double size = magnitude(x), square = x * x;
  const double large = 1.0 - 2.0 / (scaled_exp(size > 20.0 ? 40.0 : 2.0 * size, 0) + 1.0);
  const double small = size + size * square * polynomial(square, c);
  return with_sign(size < 0.55 ? small : large, x);
}

}  // namespace springnet::sdk
