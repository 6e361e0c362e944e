#include "check/memory.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>

namespace springnet::check {
namespace {

constexpr std::size_t room = 64;  // numbers

// A guarded array: pages, the first and the last of which cannot be accessed.
struct Region {
  std::uintptr_t begin, end;  // of all pages; 0: free
  std::uintptr_t first_data, end_of_data;
  bool is_input;
  char name[64];
};
// A fixed table, which a signal handler may read.
constexpr std::size_t most_regions = 8192;
Region regions[most_regions];
std::size_t region_count = 0;

Fault fault(Fault::Kind kind, const char* name) noexcept {
  Fault result{kind, {}};
  std::strncpy(result.name, name, sizeof result.name - 1);
  return result;
}

}  // namespace

Fault fault_at(const void* address) noexcept {
  const auto at = reinterpret_cast<std::uintptr_t>(address);
  for (std::size_t k = 0; k < region_count; ++k) {
    const Region& region = regions[k];
    if (at < region.begin || at >= region.end) continue;
    if (at >= region.end_of_data) return fault(Fault::Kind::beyond, region.name);
    if (at < region.first_data) return fault(Fault::Kind::before, region.name);
    return fault(region.is_input ? Fault::Kind::read_only : Fault::Kind::none, region.name);
  }
  constexpr std::uintptr_t first_page = 4096;
  if (at < first_page) return fault(Fault::Kind::null, "a null pointer, such as an output that is not wanted");
  return {};
}

double* Memory::spare() noexcept {
  static double numbers[4096];
  return numbers;
}

Memory::~Memory() {
  for (const std::size_t k : regions_) {
    munmap(reinterpret_cast<void*>(regions[k].begin), regions[k].end - regions[k].begin);
    regions[k] = {};
  }
  while (region_count > 0 && regions[region_count - 1].begin == 0) --region_count;
}

void* Memory::take(std::size_t bytes, const std::string& name, bool is_input) {
  if (layout_ == Layout::roomy) {
    const std::size_t numbers = (bytes + sizeof(double) - 1) / sizeof(double);
    std::vector<double>& memory = roomy_.emplace_back(numbers + 2 * room + 16, 0.0);
    const auto base = reinterpret_cast<std::uintptr_t>(memory.data() + room);
    const std::uintptr_t aligned = (base + 63) / 64 * 64 + (offset_ % 8) * sizeof(double);
    return reinterpret_cast<void*>(aligned);
  }
  if (region_count == most_regions) throw std::bad_alloc();
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t pages = bytes == 0 ? 0 : (bytes + page - 1) / page;
  const std::size_t size = (pages + 2) * page;
  void* const memory = mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  char* const data = static_cast<char*>(memory) + page;
  if (pages > 0 && mprotect(data, pages * page, PROT_READ | PROT_WRITE) != 0) {
    munmap(memory, size);
    throw std::bad_alloc();
  }
  Region& region = regions[region_count];
  region = {};
  region.begin = reinterpret_cast<std::uintptr_t>(memory);
  region.end = region.begin + size;
  region.first_data = region.begin + page;
  region.end_of_data = region.first_data + pages * page;
  region.is_input = is_input;
  std::strncpy(region.name, name.c_str(), sizeof region.name - 1);
  regions_.push_back(region_count++);
  return layout_ == Layout::at_end ? data + pages * page - bytes : data;
}

void Memory::protect() {
  for (const std::size_t k : regions_) {
    const Region& region = regions[k];
    if (region.is_input && region.end_of_data > region.first_data)
      mprotect(reinterpret_cast<void*>(region.first_data), region.end_of_data - region.first_data, PROT_READ);
  }
}

}  // namespace springnet::check
