// What the functions in this folder share: bits of doubles, powers of two, products whose error is known.
//
// Everything is written so that a loop over it vectorises for SSE2, AVX2 and AVX-512: no branch, no table, no 64-bit
// comparison, no arithmetic shift, no conversion between integers and doubles. Without contraction to fused
// multiply-add (-ffp-contract=off) all instruction sets round alike. The rounding mode is to nearest.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#if defined(__FAST_MATH__)
#error "springnet laws must give the same bits for every instruction set and tile size: compile without -ffast-math"
#endif

#if defined(__GNUC__) || defined(__clang__)
#define SPRINGNET_INLINE __attribute__((always_inline)) inline
#define SPRINGNET_APART __attribute__((noinline))  // what loops call for a rare element
#define SPRINGNET_FLATTEN __attribute__((flatten))
#else
#define SPRINGNET_INLINE inline
#define SPRINGNET_APART
#define SPRINGNET_FLATTEN
#endif

namespace springnet::sdk::detail {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr std::uint64_t one_bits = 0x3ff0000000000000, sign_bit = 0x8000000000000000;

[[nodiscard]] SPRINGNET_INLINE std::uint64_t bits_of(double x) { return std::bit_cast<std::uint64_t>(x); }
[[nodiscard]] SPRINGNET_INLINE double from_bits(std::uint64_t bits) { return std::bit_cast<double>(bits); }

[[nodiscard]] SPRINGNET_INLINE double magnitude(double x) { return __builtin_fabs(x); }
[[nodiscard]] SPRINGNET_INLINE double with_sign(double x, double sign) { return __builtin_copysign(x, sign); }
// A small integer as a double and in the low bits of a word.
struct Rounded {
  double value;
  std::uint64_t bits;  // value + an integer that 2048 divides
};
// x rounded to an integer, |x| < 2^51. The sum is a multiple of 1, so that its low bits are the integer.
[[nodiscard]] SPRINGNET_INLINE Rounded rounded(double x) {
  constexpr double shift = 0x1.8p52;
  const double sum = x + shift;
  return {sum - shift, bits_of(sum)};
}
// The integer n, 0 <= n < 2^52, as a double.
[[nodiscard]] SPRINGNET_INLINE double to_double(std::uint64_t n) { return from_bits(n | 0x4330000000000000) - 0x1p52; }

// x 2^n for |n| <= 1100 and normal x, rounded once, also where the result is subnormal: the first of the two
// factors keeps it normal.
[[nodiscard]] SPRINGNET_INLINE double scaled(double x, std::uint64_t n) {
  const std::uint64_t biased = (n + 2046) & 4095, half = biased >> 1;
  return x * from_bits(half << 52) * from_bits((biased - half) << 52);
}

// The upper 26 bits of x; what is left has 27. Products of two such numbers are exact.
[[nodiscard]] SPRINGNET_INLINE double upper(double x) { return from_bits(bits_of(x) & 0xfffffffff8000000); }

// high + low = a + b exactly, if |a| >= |b| or a = 0.
struct Sum {
  double high, low;
};
[[nodiscard]] SPRINGNET_INLINE Sum ordered_sum(double a, double b) {
  const double high = a + b;
  return {high, b - (high - a)};
}
[[nodiscard]] SPRINGNET_INLINE Sum exact_sum(double a, double b) {
  const double high = a + b, b_part = high - a;
  return {high, (a - (high - b_part)) + (b - b_part)};
}

// c[First] + c[First + Step] x + c[First + 2 Step] x^2 + … by Horner's rule.
template <std::size_t First, std::size_t Step, std::size_t Count>
[[nodiscard]] SPRINGNET_INLINE double horner(double x, const double (&c)[Count]) {
  constexpr std::size_t last = First + (Count - 1 - First) / Step * Step;
  double sum = c[last];
  for (std::size_t i = last; i > First; i -= Step) sum = sum * x + c[i - Step];
  return sum;
}
// c[0] + c[1] x + c[2] x^2 + …: even and odd powers apart, each by Horner's rule. One operation more than that rule for
// all, but half of its latency, which counts where loops are long.
template <std::size_t Count>
[[nodiscard]] SPRINGNET_INLINE double polynomial(double x, const double (&c)[Count]) {
  return horner<0, 2>(x * x, c) + x * horner<1, 2>(x * x, c);
}
// A positive number as 2^exponent * fraction, fraction in [1/sqrt 2, sqrt 2). For 0, infinity and nan: anything.
struct Split {
  double exponent, fraction;
  std::uint64_t exponent_bits;  // exponent + 1023
};
[[nodiscard]] SPRINGNET_INLINE Split split_normal(double x) {
  // Adding this carries into the exponent where the fraction, in [1, 2), is at least sqrt 2.
  const std::uint64_t carried = bits_of(x) + (one_bits - 0x3fe6a09e667f3bcd);
  const std::uint64_t exponent = carried >> 52;
  const double fraction = from_bits(bits_of(x) - ((carried & 0xfff0000000000000) - one_bits));
  return {to_double(exponent) - 1023.0, fraction, exponent};
}
[[nodiscard]] SPRINGNET_INLINE Split split(double x) {
  const bool subnormal = x < 0x1p-1022;
  Split result = split_normal(subnormal ? x * 0x1p54 : x);
  result.exponent -= subnormal ? 54.0 : 0.0;
  return result;
}

}  // namespace springnet::sdk::detail
