#include "short_of_memory.hpp"

#include <cstdlib>
#include <new>

namespace springnet::testing {

thread_local int allocations_left = -1;

}  // namespace springnet::testing

void* operator new(std::size_t size) {
  using springnet::testing::allocations_left;
  if (allocations_left >= 0 && --allocations_left < 0) throw std::bad_alloc();
  if (void* const memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
// The library's own asks the one above, the sanitizers' does not.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  try {
    return operator new(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
