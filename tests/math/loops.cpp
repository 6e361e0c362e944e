#include "loops.hpp"

#include <springnet/sdk/dual.hpp>
#include <springnet/sdk/kernel.hpp>

namespace springnet::test {
namespace {

#define SPRINGNET_UNARY(X) \
  X(exp)                   \
  X(expm1)                 \
  X(log) X(log1p) X(log10) X(sqrt) X(cbrt) X(sin) X(cos) X(tan) X(asin) X(acos) X(atan) X(sinh) X(cosh) X(tanh) X(erf)
#define SPRINGNET_SLOPES(X) X(expm1_slope)
#define SPRINGNET_BINARY(X) X(pow) X(quick_pow) X(atan2) X(hypot) X(plane_angle)

#define SPRINGNET_TYPE_1(name)                                                   \
  struct Of_##name {                                                             \
    SPRINGNET_INLINE static double at(double x, double) { return sdk::name(x); } \
  };
#define SPRINGNET_TYPE_2(name)                                                        \
  struct Of_##name {                                                                  \
    SPRINGNET_INLINE static double at(double x, double y) { return sdk::name(x, y); } \
  };
SPRINGNET_UNARY(SPRINGNET_TYPE_1)
SPRINGNET_BINARY(SPRINGNET_TYPE_2)
struct Of_expm1_slope {
  SPRINGNET_INLINE static double at(double x, double) { return sdk::detail::expm1_and_exp(x).value; }
};

template <class Of>
SPRINGNET_INLINE void run(const double* __restrict x, const double* __restrict y, double* __restrict out,
                          std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = Of::at(x[i], y[i]);
}
template <class Of>
void generic(const double* x, const double* y, double* out, std::size_t count) {
  run<Of>(x, y, out, count);
}
#define SPRINGNET_LOOP(name) {#name, &SPRINGNET_SET<Of_##name>},
#define SPRINGNET_SET generic
constexpr Loop all_generic[] = {SPRINGNET_UNARY(SPRINGNET_LOOP) SPRINGNET_BINARY(SPRINGNET_LOOP)
                                    SPRINGNET_SLOPES(SPRINGNET_LOOP)};
#undef SPRINGNET_SET

#if defined(__x86_64__) && !defined(SPRINGNET_GENERIC_ONLY)
template <class Of>
[[gnu::target("avx2")]] void avx2(const double* x, const double* y, double* out, std::size_t count) {
  run<Of>(x, y, out, count);
}
template <class Of>
[[gnu::target(SPRINGNET_TARGET_AVX512)]] void avx512(const double* x, const double* y, double* out, std::size_t count) {
  run<Of>(x, y, out, count);
}
#define SPRINGNET_SET avx2
constexpr Loop all_avx2[] = {SPRINGNET_UNARY(SPRINGNET_LOOP) SPRINGNET_BINARY(SPRINGNET_LOOP)
                                 SPRINGNET_SLOPES(SPRINGNET_LOOP)};
#undef SPRINGNET_SET
#define SPRINGNET_SET avx512
constexpr Loop all_avx512[] = {SPRINGNET_UNARY(SPRINGNET_LOOP) SPRINGNET_BINARY(SPRINGNET_LOOP)
                                   SPRINGNET_SLOPES(SPRINGNET_LOOP)};
#else
constexpr std::span<const Loop> all_avx2, all_avx512;
#endif

}  // namespace

std::span<const Loop> generic_loops() { return all_generic; }
std::span<const Loop> avx2_loops() { return all_avx2; }
std::span<const Loop> avx512_loops() { return all_avx512; }

}  // namespace springnet::test
