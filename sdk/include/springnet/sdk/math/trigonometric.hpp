// sin, cos, tan.
#pragma once

#include <springnet/sdk/math/reduction.hpp>

namespace springnet::sdk {
namespace detail {

// Odd ? b : a, by the lowest bit.
[[nodiscard]] SPRINGNET_INLINE double chosen(std::uint64_t odd, double a, double b) {
  const std::uint64_t mask = 0 - (odd & 1);
  return from_bits((bits_of(a) & ~mask) | (bits_of(b) & mask));
}

// sin(r + rest) = r + r^3 p(r^2), cos(r + rest) = 1 - r^2/2 + r^4 q(r^2) for |r| <= pi/4. The polynomials interpolate
// in Chebyshev points and change the results by at most 2^-57 and 2^-59 of themselves.
[[nodiscard]] SPRINGNET_INLINE double sine_of_reduced(double r, double rest) {
  constexpr double c[] = {-0x1.5555555555555p-3,  0x1.1111111111110p-7,  -0x1.a01a01a019936p-13, 0x1.71de3a54605eep-19,
                          -0x1.ae64541266378p-26, 0x1.61217ec01749dp-33, -0x1.ab17a79237a19p-41};
  const double z = r * r;
  return r + (rest + r * z * polynomial(z, c));
}
[[nodiscard]] SPRINGNET_INLINE double cosine_of_reduced(double r, double rest) {
  constexpr double c[] = {0x1.5555555555555p-5,   -0x1.6c16c16c16966p-10, 0x1.a01a019f4e867p-16,
                          -0x1.27e4fa17a41b4p-22, 0x1.1eeb68b109173p-29,  -0x1.907d7aebd5e3dp-37};
  const double z = r * r, half = 0.5 * z, head = 1.0 - half;
  return head + (((1.0 - head) - half) + (z * z * polynomial(z, c) - r * rest));
}

// The sine of an angle plus `quarters` right angles.
[[nodiscard]] SPRINGNET_INLINE double shifted_sine(const ReducedAngle& a, std::uint64_t quarters) {
  const std::uint64_t all = a.quarters + quarters;
  const double size = chosen(all, sine_of_reduced(a.r, a.rest), cosine_of_reduced(a.r, a.rest));
  return from_bits(bits_of(size) ^ ((all & 2) << 62));
}

}  // namespace detail

// Within 0.8 ulp, for every argument.
[[nodiscard]] SPRINGNET_INLINE double sin(double x) {
  const double result = detail::shifted_sine(detail::reduced_angle(x), 0);
  return x == 0.0 ? x : result;
}
[[nodiscard]] SPRINGNET_INLINE double cos(double x) { return detail::shifted_sine(detail::reduced_angle(x), 1); }

// Within 1.5 ulp. tan r = r + r^3 p(r^2); p changes it by at most 2^-56 of itself. Odd multiples: -1 / tan r.
[[nodiscard]] SPRINGNET_INLINE double tan(double x) {
  using namespace detail;
  constexpr double c[] = {0x1.5555555555555p-2,  0x1.1111111111099p-3,   0x1.ba1ba1ba29cd2p-5,  0x1.664f487d7e84cp-6,
                          0x1.226e366378b07p-7,  0x1.d6d3941ed0842p-9,   0x1.7da7fd40e93d4p-10, 0x1.351b5fae63e47p-11,
                          0x1.f9e57ea24e246p-13, 0x1.7960a69680fd6p-14,  0x1.d2803ca5e2238p-15, -0x1.72a937585429ap-17,
                          0x1.3292ecbafa24dp-15, -0x1.338e0c452bd76p-16, 0x1.1cc93a6631a32p-17};
  const ReducedAngle a = reduced_angle(x);
  const double z = a.r * a.r;
  const double curved = a.rest * (1.0 + z) + a.r * z * polynomial(z, c);
  const Sum tangent = ordered_sum(a.r, curved);
  // 1 / (t + e) = 1/t - e / t^2.
  const double inverse = -1.0 / tangent.high;
  const double result = chosen(a.quarters, tangent.high, inverse + inverse * inverse * tangent.low);
  return x == 0.0 ? x : result;
}

}  // namespace springnet::sdk
