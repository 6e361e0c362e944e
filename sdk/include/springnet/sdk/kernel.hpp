// Shared by law.hpp and neuron.hpp: parameters of a formula, arrays with uniform stride, kernels compiled for several
// instruction sets.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <springnet/sdk/plugin.h>
#include <springnet/sdk/dual.hpp>
#include <springnet/sdk/message.hpp>

#if defined(__clang__)
#define SPRINGNET_TARGET_AVX512 "avx512f,avx512dq,avx512vl,avx512bw,avx512cd"
#else
#define SPRINGNET_TARGET_AVX512 "avx512f,avx512dq,avx512vl,avx512bw,avx512cd,prefer-vector-width=512"
#endif

// Asserts that no iteration of the following loop reads what another one writes. Clang finds out by __restrict.
#if defined(__clang__)
#define SPRINGNET_INDEPENDENT_ITERATIONS
#else
#define SPRINGNET_INDEPENDENT_ITERATIONS _Pragma("GCC ivdep")
#endif

namespace springnet::sdk {

// The parameters of one element or node, in the order in which they are declared.
template <class Real>
class Parameters {
 public:
  SPRINGNET_INLINE explicit constexpr Parameters(const Real* values) : values_(values) {}
  SPRINGNET_INLINE constexpr const Real& operator[](std::size_t index) const { return values_[index]; }

 private:
  const Real* values_;
};

namespace detail {

// Elements a kernel works on at a time; its arrays then stay in the first-level cache.
inline constexpr std::uint32_t chunk_size = 256;

// Up to Count input arrays with strides 0 or 1, read chunk by chunk. If all have stride 0 (`uniform`), the values are
// loop constants; with first_apart, so are all others if the first alone varies. Otherwise those with stride 0 are
// copied to a buffer once, so that every loop has unit stride and vectorises.
template <std::size_t Count, bool first_apart = false>
class Streams {
 public:
  // expanded: as if none were uniform.
  SPRINGNET_INLINE Streams(const double* const* arrays, const std::uint32_t* strides, std::uint32_t count,
                           bool expanded = false) {
    for (std::size_t j = 0; j < Count; ++j) {
      source_[j] = arrays[j];
      stride_[j] = strides[j];
      rest_is_uniform_ = rest_is_uniform_ && (j == 0 || strides[j] == 0);
    }
    rest_is_uniform_ = rest_is_uniform_ && !expanded;
    uniform_ = rest_is_uniform_ && (Count == 0 || strides[0] == 0);
    if (first_apart ? rest_is_uniform_ : uniform_) return;
    const std::uint32_t length = std::min(count, chunk_size);
    for (std::size_t j = 0; j < Count; ++j) {
      if (stride_[j] != 0) continue;
      std::fill_n(buffer_[j], length, *arrays[j]);
      source_[j] = buffer_[j];
    }
  }
  [[nodiscard]] SPRINGNET_INLINE bool uniform() const { return uniform_; }
  // All but the first array have stride 0.
  [[nodiscard]] SPRINGNET_INLINE bool rest_is_uniform() const { return rest_is_uniform_; }
  // Array j from element `begin` on; with stride 0 the same buffer or value for every chunk.
  [[nodiscard]] SPRINGNET_INLINE const double* at(std::size_t j, std::uint32_t begin) const {
    return source_[j] + (stride_[j] != 0 ? begin : 0u);
  }

 private:
  std::array<const double*, Count> source_;
  std::array<std::uint32_t, Count> stride_;
  bool uniform_ = true, rest_is_uniform_ = true;
  double buffer_[Count == 0 ? 1 : Count][chunk_size];
};

// Kernel::run(batch), compiled for the instruction set that the host chose. An unknown set, or one of another
// processor family, falls back to the generic code, which gives the same bits.
template <class Kernel, class Batch>
SPRINGNET_FLATTEN void run_generic(const Batch& batch) {
  Kernel::run(batch);
}
#if defined(__x86_64__) && defined(__GNUC__) && !defined(SPRINGNET_GENERIC_ONLY)
template <class Kernel, class Batch>
[[gnu::target("avx2")]] SPRINGNET_FLATTEN void run_avx2(const Batch& batch) {
  Kernel::run(batch);
}
template <class Kernel, class Batch>
[[gnu::target(SPRINGNET_TARGET_AVX512)]] SPRINGNET_FLATTEN void run_avx512(const Batch& batch) {
  Kernel::run(batch);
}
#endif
template <class Kernel, class Batch>
void run(const Batch& batch) {
#if defined(__x86_64__) && defined(__GNUC__) && !defined(SPRINGNET_GENERIC_ONLY)
  if (batch.instruction_set == SPRINGNET_AVX512) return run_avx512<Kernel>(batch);
  if (batch.instruction_set == SPRINGNET_AVX2) return run_avx2<Kernel>(batch);
#endif
  run_generic<Kernel>(batch);
}

}  // namespace detail
}  // namespace springnet::sdk
