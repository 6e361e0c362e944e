// Angles less the nearest multiple of 90 degrees, for sin, cos and tan.
#pragma once

#include <initializer_list>

#include <springnet/sdk/math/number.hpp>

namespace springnet::sdk::detail {

// An angle less `quarters` right angles, in [-pi/4, pi/4], as r and the error of its rounding. Only the lowest two bits
// of `quarters` count.
struct ReducedAngle {
  std::uint64_t quarters;
  double r, rest;
};

// Up to here right angles are subtracted as they are below.
inline constexpr double largest_ordinary_angle = 0x1p23;

// pi/2 is the sum of three numbers of 30 bits, whose products with an integer below 2^23 are exact, and a fourth one:
// 143 bits. The rounding errors of the differences are kept. Near a multiple of pi/2, where at most 60 bits cancel, r
// has all its bits.
[[nodiscard]] SPRINGNET_INLINE ReducedAngle reduced_ordinary_angle(double x) {
  constexpr double two_over_pi = 0x1.45f306dc9c883p-1;
  constexpr double part[] = {0x1.921fb54000000p+0, 0x1.10b4611800000p-30, 0x1.313198a000000p-61, 0x1.701b839a25205p-92};
  const Rounded k = rounded(x * two_over_pi);
  const Sum first = exact_sum(x - k.value * part[0], -(k.value * part[1]));
  const Sum second = exact_sum(first.high, -(k.value * part[2]));
  const Sum result = ordered_sum(second.high, (second.low + first.low) - k.value * part[3]);
  return {k.bits, result.high, result.low};
}

// The same for any angle from 2^23 on, after M. H. Payne and R. N. Hanek, Radian reduction for trigonometric functions,
// ACM SIGNUM Newsletter 18 (1983) 19-24: the product of the 53 bits of x with those 192 bits of 2/pi that matter. Bits
// of 2/pi before them give multiples of 2 pi, those after them less than 2^-75 of r, since at most 62 bits cancel.
[[nodiscard]] inline ReducedAngle reduced_huge_angle(double x) {
  __extension__ using Wide = unsigned __int128;
  // Behind 64 zeros the bits of 2/pi.
  static constexpr std::uint64_t two_over_pi[] = {
      0x0000000000000000, 0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
      0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484, 0xe99c7026b45f7e41,
      0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f, 0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7,
      0x4f463f669e5fea2d, 0x7527bac7ebe5f17b, 0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab};
  const std::uint64_t bits = bits_of(x), fraction = (bits & 0x000fffffffffffff) | 0x0010000000000000;
  const std::uint64_t exponent = bits >> 52 & 0x7ff;
  // The unit of the fraction times the first bit of the window is 2.
  const std::uint64_t first = exponent - 1075 + 62, word = first / 64, shift = first % 64;
  std::uint64_t window[3];
  for (std::uint64_t i = 0; i < 3; ++i) {
    window[i] =
        shift == 0 ? two_over_pi[word + i] : two_over_pi[word + i] << shift | two_over_pi[word + i + 1] >> (64 - shift);
  }
  // The product modulo 4 in units of 2^-190, highest word first.
  const Wide lowest = Wide{fraction} * window[2], middle = Wide{fraction} * window[1] + (lowest >> 64);
  std::uint64_t product[3] = {fraction * window[0] + static_cast<std::uint64_t>(middle >> 64),
                              static_cast<std::uint64_t>(middle), static_cast<std::uint64_t>(lowest)};
  std::uint64_t quarters = product[0] >> 62;
  const bool negative = (product[0] >> 61 & 1) != 0;
  product[0] &= 0x3fffffffffffffff;
  if (negative) {  // the nearest multiple is the next one: 1 - fraction
    ++quarters;
    for (std::uint64_t& each : product) each = ~each;
    product[0] &= 0x3fffffffffffffff;
    if (++product[2] == 0 && ++product[1] == 0) ++product[0];
  }
  // Its sum with parts of 30 bits and then 53.
  double high = 0.0, low = 0.0, unit = 0x1p-30;
  for (const std::uint64_t each : product) {
    for (const int down : {32, 0}) {
      const Sum sum = ordered_sum(high, static_cast<double>(each >> down & 0xffffffff) * unit);
      high = sum.high;
      low += sum.low;
      unit *= 0x1p-32;
    }
  }
  const Sum turn = ordered_sum(high, low);
  constexpr double half_pi = 0x1.921fb54442d18p+0, half_pi_rest = 0x1.1a62633145c07p-54;
  const double a = upper(turn.high), a_rest = turn.high - a, b = upper(half_pi), b_rest = half_pi - b;
  const double r = turn.high * half_pi;
  const double rest =
      ((a * b - r) + (a * b_rest + a_rest * b)) + a_rest * b_rest + turn.high * half_pi_rest + turn.low * half_pi;
  const bool below = negative != (x < 0.0);
  return {x < 0.0 ? 0 - quarters : quarters, below ? -r : r, below ? -rest : rest};
}

[[nodiscard]] SPRINGNET_INLINE ReducedAngle reduced_angle(double x) {
  if (magnitude(x) > largest_ordinary_angle && magnitude(x) < infinity) return reduced_huge_angle(x);
  return reduced_ordinary_angle(x);
}

}  // namespace springnet::sdk::detail
