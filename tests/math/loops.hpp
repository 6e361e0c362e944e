// A loop over each function, compiled for an instruction set.
#pragma once

#include <cstddef>
#include <span>

namespace springnet::test {

struct Loop {
  const char* name;
  // out[i] = f(x[i], y[i]); functions of one argument take x.
  void (*run)(const double* x, const double* y, double* out, std::size_t count);
};

[[nodiscard]] std::span<const Loop> generic_loops();
[[nodiscard]] std::span<const Loop> avx2_loops();
[[nodiscard]] std::span<const Loop> avx512_loops();

}  // namespace springnet::test
