#include "check/heap.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SPRINGNET_COUNTS_HEAP
#endif

namespace springnet::check {

#ifdef SPRINGNET_COUNTS_HEAP
namespace {

// glibc counts what its cache of a thread keeps of freed memory as in use. Filled up, it always keeps the same.
void fill_cache() {
  constexpr std::size_t largest = 1040, apart = 16, chunks = 8;  // of each size; the cache keeps seven
  std::array<void*, largest / apart * chunks> taken{};
  std::size_t k = 0;
  for (std::size_t size = 8; size <= largest && k + chunks <= taken.size(); size += apart)
    for (std::size_t i = 0; i < chunks; ++i) taken[k++] = std::malloc(size);
  for (void* each : taken) std::free(each);
}

}  // namespace
#endif

std::optional<std::size_t> heap_in_use() {
#ifdef SPRINGNET_COUNTS_HEAP
  fill_cache();
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
#else
  return {};
#endif
}

double kept_by_each(const std::function<void()>& what, int calls) {
  // The first calls fill caches; what grows in each of the later quarters is kept by calls.
  std::array<double, 4> grown{};
  for (int k = 0; k < calls; ++k) what();
  for (double& growth : grown) {
    const std::optional<std::size_t> before = heap_in_use();
    if (!before) return 0.0;
    for (int k = 0; k < calls; ++k) what();
    growth = (static_cast<double>(heap_in_use().value_or(0)) - static_cast<double>(*before)) / calls;
  }
  return std::max(0.0, *std::min_element(grown.begin(), grown.end()));
}

}  // namespace springnet::check
