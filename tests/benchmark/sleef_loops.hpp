// Loops over SLEEF's functions of up to 1 ulp, each for one instruction set.
#pragma once

#include <cstddef>
#include <span>

namespace springnet::benchmark {

struct SleefLoop {
  const char* name;
  void (*run)(const double* x, const double* y, double* out, std::size_t count);  // count: a multiple of 8
};

[[nodiscard]] std::span<const SleefLoop> sleef_generic();  // SSE2
[[nodiscard]] std::span<const SleefLoop> sleef_avx2();     // with FMA
[[nodiscard]] std::span<const SleefLoop> sleef_avx512();   // with FMA

}  // namespace springnet::benchmark
