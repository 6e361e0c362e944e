// Compiled once for each instruction set, whose flags decide what sleef.h declares.
#include "sleef_loops.hpp"

#include <immintrin.h>
#include <sleef.h>

namespace springnet::benchmark {
namespace {

#if defined(__AVX512F__)
#define SPRINGNET_SLEEF(name, accuracy) Sleef_##name##d8_##accuracy##avx512f
#define SPRINGNET_LOOPS sleef_avx512
constexpr std::size_t width = 8;
__m512d load(const double* x) { return _mm512_loadu_pd(x); }
void store(double* x, __m512d value) { _mm512_storeu_pd(x, value); }
#elif defined(__AVX2__)
#define SPRINGNET_SLEEF(name, accuracy) Sleef_##name##d4_##accuracy##avx2
#define SPRINGNET_LOOPS sleef_avx2
constexpr std::size_t width = 4;
__m256d load(const double* x) { return _mm256_loadu_pd(x); }
void store(double* x, __m256d value) { _mm256_storeu_pd(x, value); }
#else
#define SPRINGNET_SLEEF(name, accuracy) Sleef_##name##d2_##accuracy##sse2
#define SPRINGNET_LOOPS sleef_generic
constexpr std::size_t width = 2;
__m128d load(const double* x) { return _mm_loadu_pd(x); }
void store(double* x, __m128d value) { _mm_storeu_pd(x, value); }
#endif

#define SPRINGNET_ONE(name)                                                                                  \
  {#name, [](const double* x, const double*, double* out, std::size_t count) {                               \
     for (std::size_t i = 0; i < count; i += width) store(out + i, SPRINGNET_SLEEF(name, u10)(load(x + i))); \
   }},
#define SPRINGNET_TWO(name, accuracy)                                             \
  {#name, [](const double* x, const double* y, double* out, std::size_t count) {  \
     for (std::size_t i = 0; i < count; i += width)                               \
       store(out + i, SPRINGNET_SLEEF(name, accuracy)(load(x + i), load(y + i))); \
   }},

constexpr SleefLoop loops[] = {
    SPRINGNET_ONE(exp) SPRINGNET_ONE(expm1) SPRINGNET_ONE(log) SPRINGNET_ONE(log1p) SPRINGNET_ONE(log10)
        SPRINGNET_ONE(cbrt) SPRINGNET_ONE(sin) SPRINGNET_ONE(cos) SPRINGNET_ONE(tan) SPRINGNET_ONE(asin)
            SPRINGNET_ONE(acos) SPRINGNET_ONE(atan) SPRINGNET_ONE(sinh) SPRINGNET_ONE(cosh) SPRINGNET_ONE(tanh)
                SPRINGNET_ONE(erf) SPRINGNET_TWO(pow, u10) SPRINGNET_TWO(atan2, u10) SPRINGNET_TWO(hypot, u05)};

}  // namespace

std::span<const SleefLoop> SPRINGNET_LOOPS() { return loops; }

}  // namespace springnet::benchmark
