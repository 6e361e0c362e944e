// Angles less the nearest multiple of 90 degrees, for sin, cos and tan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include <springnet/sdk/math/number.hpp>

namespace springnet::sdk::detail {

// An angle less `quarters` right angles, in [-pi/4, pi/4], as r - excess: r is the difference rounded. Only the lowest
// two bits of `quarters` count. A zero angle has r with its sign and the excess +0.
struct ReducedAngle {
  std::uint64_t quarters;
  double r, excess;
};

// Up to here right angles are subtracted as follows; larger ones are folded first.
inline constexpr double largest_ordinary_angle = 0x1p15;

// pi/2 is the sum of two numbers of 38 bits, whose products with an integer below 2^15 are exact, and a third one: 129
// bits. x - k part[0] is exact; what the next difference loses is kept. Near a multiple of pi/2, where at most 58 bits
// cancel, r has all its bits.
[[nodiscard]] SPRINGNET_INLINE ReducedAngle reduced_ordinary_angle(double x) {
  constexpr double two_over_pi = 0x1.45f306dc9c883p-1;
  constexpr double part[] = {0x1.921fb54440000p+0, 0x1.68c234c4c0000p-39, 0x1.98a2e03707345p-77};
  const Rounded k = rounded(x * two_over_pi);
  const double first = x - k.value * part[0], product = k.value * part[1], second = first - product;
  const double low = (product - (first - second)) + k.value * part[2], r = second - low;
  return {k.bits, r, (r - second) + low};
}

// The same for any angle from 2^15 on, after M. H. Payne and R. N. Hanek, Radian reduction for trigonometric functions,
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
  const Sum angle = ordered_sum(r, rest);
  const double sign = negative != (x < 0.0) ? -1.0 : 1.0;
  return {x < 0.0 ? 0 - quarters : quarters, sign * angle.high, -sign * angle.low};
}

// An angle as one double: itself up to `largest_ordinary_angle`, else r 2^(256 quarters), quarters from 0 to 3, with
// |r| above 2^-65.
struct FoldedAngle {
  static constexpr bool ordinary_is_zero = false;
  [[nodiscard]] static double of_huge(double x) {
    const ReducedAngle angle = reduced_huge_angle(x);
    return angle.r * from_bits(one_bits + ((angle.quarters & 3) << 60));
  }
};
// The excess that belongs to r.
struct FoldedExcess {
  static constexpr bool ordinary_is_zero = true;
  [[nodiscard]] static double of_huge(double x) { return reduced_huge_angle(x).excess; }
};
template <class Fold>
[[nodiscard]] SPRINGNET_INLINE double fold(double x) {
  const bool huge = magnitude(x) > largest_ordinary_angle && magnitude(x) < infinity;
  return __builtin_expect(static_cast<long>(huge), 0) != 0 ? Fold::of_huge(x) : (Fold::ordinary_is_zero ? 0.0 : x);
}

}  // namespace springnet::sdk::detail

// Folding is the one thing in sdk/math.hpp that has a branch. For GCC it is a function with variants for vectors, so
// that loops that call it vectorise: in a vector there are only ordinary angles but in rare cases, and the variants
// then return at once. Their names are those of the vector function ABI of x86-64
// (https://sourceware.org/glibc/wiki/libmvec), by which GCC calls them. They are emitted wherever this header is
// included, since GCC calls them after it has decided which functions are used. Other compilers inline the branch, and
// do not vectorise these loops.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
extern "C" {
[[nodiscard, gnu::simd("notinbranch"), gnu::const]] double springnet_folded_angle(double x) noexcept;
[[nodiscard, gnu::simd("notinbranch"), gnu::const]] double springnet_folded_excess(double x) noexcept;
}

namespace springnet::sdk::detail {

template <class Number, std::size_t count>
struct VectorOf {
  using Type [[gnu::vector_size(count * sizeof(Number))]] = Number;
};
template <std::size_t count>
using Angles = typename VectorOf<double, count>::Type;

template <class Fold>
[[gnu::noinline, gnu::cold]] void fold_each(double* x, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) x[i] = fold<Fold>(x[i]);
}
template <class Fold, std::size_t count>
SPRINGNET_INLINE void fold_all(Angles<count>& x) {
  using Bits = typename VectorOf<std::uint64_t, count>::Type;
  // The highest bit is set if an angle is above the limit.
  const Bits above = (reinterpret_cast<Bits>(x) & ~sign_bit) + (~sign_bit - bits_of(largest_ordinary_angle));
  std::uint64_t any = 0;
  for (std::size_t i = 0; i < count; ++i) any |= above[i];
  if (__builtin_expect(static_cast<long>(any >> 63), 0) == 0) {
    if constexpr (Fold::ordinary_is_zero) x = Angles<count>{};
    return;
  }
  double each[count];
  for (std::size_t i = 0; i < count; ++i) each[i] = x[i];
  fold_each<Fold>(each, count);
  for (std::size_t i = 0; i < count; ++i) x[i] = each[i];
}
#define SPRINGNET_VARIANT(name, Fold, Vector, symbol, ...) \
  __VA_ARGS__ inline Vector name(Vector x) asm(symbol);    \
  [[gnu::used]] __VA_ARGS__ inline Vector name(Vector x) { \
    fold_all<Fold, sizeof x / sizeof(double)>(x);          \
    return x;                                              \
  }
#define SPRINGNET_VARIANTS(name, Fold, symbol)                                                 \
  inline double name(double x) asm(symbol);                                                    \
  [[gnu::used]] inline double name(double x) { return fold<Fold>(x); }                         \
  SPRINGNET_VARIANT(name##_sse2, Fold, Angles<2>, "_ZGVbN2v_" symbol)                          \
  SPRINGNET_VARIANT(name##_avx, Fold, Angles<4>, "_ZGVcN4v_" symbol, [[gnu::target("avx")]])   \
  SPRINGNET_VARIANT(name##_avx2, Fold, Angles<4>, "_ZGVdN4v_" symbol, [[gnu::target("avx2")]]) \
  SPRINGNET_VARIANT(name##_avx512, Fold, Angles<8>, "_ZGVeN8v_" symbol, [[gnu::target("avx512f")]])
SPRINGNET_VARIANTS(folded_angle, FoldedAngle, "springnet_folded_angle")
SPRINGNET_VARIANTS(folded_excess, FoldedExcess, "springnet_folded_excess")
#undef SPRINGNET_VARIANTS
#undef SPRINGNET_VARIANT

}  // namespace springnet::sdk::detail
#else
namespace springnet::sdk::detail {
[[nodiscard]] SPRINGNET_INLINE double springnet_folded_angle(double x) { return fold<FoldedAngle>(x); }
[[nodiscard]] SPRINGNET_INLINE double springnet_folded_excess(double x) { return fold<FoldedExcess>(x); }
}  // namespace springnet::sdk::detail
#endif

namespace springnet::sdk::detail {

// For huge angles the excess is 0, and r has the error of a rounding.
[[nodiscard]] SPRINGNET_INLINE ReducedAngle reduced_angle(double x) {
  const double folded = springnet_folded_angle(x);
  const std::uint64_t bits = bits_of(folded);
  // In the exponent of a folded angle plus 66 the bits 256 and 512 are its quarters; ordinary angles have none.
  const std::uint64_t shift = (bits + (std::uint64_t{66} << 52)) & (std::uint64_t{0x300} << 52);
  const std::uint64_t scale = magnitude(folded) > 0x1p100 ? shift : 0;
  const ReducedAngle angle = reduced_ordinary_angle(from_bits(bits - scale));
  return {angle.quarters + (scale >> 60), angle.r, angle.excess};
}

}  // namespace springnet::sdk::detail
