// A step of the recurrent network allocates nothing once the first ones have sized the buffers.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#include <doctest/doctest.h>

#include "nets.hpp"

namespace {

std::atomic<std::uint64_t> allocations{0};

void* allocate(std::size_t size) {
  ++allocations;
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void* allocate_aligned(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto step = static_cast<std::size_t>(alignment);
  void* memory = std::aligned_alloc(step, (size + step - 1) / step * step);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Those of the whole program, its libraries and plugins included.
void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void* operator new(std::size_t size, std::align_val_t alignment) { return allocate_aligned(size, alignment); }
void* operator new[](std::size_t size, std::align_val_t alignment) { return allocate_aligned(size, alignment); }
// What std::stable_sort asks for.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

TEST_CASE("a step allocates nothing") {
  using namespace springnet;
  using namespace springnet::testing;
  Network net;
  Lattice lattice;
  lattice.nodes = {6, 6, 6};
  lattice.diagonals = Diagonals::space;
  const MaterialIndex material = net.add_material(damped(3.0, 0.5));
  net.add_lattice("one", lattice, Node{}, material);
  lattice.origin = {20, 0, 0};
  net.add_lattice("two", lattice, Node{}, material);  // a second part for the wave to go on to
  for (NodeIndex k = 0; k + 50 < 216; k += 3) {
    net.add_element(Invariant::angle, {k, k + 1, k + 2}, material);
    net.add_element(Invariant::volume, {k, k + 1, k + 6, k + 36}, material);
    net.add_element(Invariant::dihedral, {k, k + 36, k + 6, k + 1}, material);
    net.add_element(Invariant::area, {k, k + 1, k + 6}, material);
  }
  net.add_element(Invariant::enclosed_volume, {0, 6, 1, 0, 1, 36, 1, 6, 36, 6, 0, 36}, material);
  net.fix(0);
  net.set_gravity({0, 0, -1});
  // The count is live: building a network has counted.
  REQUIRE(allocations.load() > 0);
  for (const LawUse& integrator :
       {single_sweep(), recurrent(synchronous, 0), recurrent(wavefront, 0), recurrent(block, 0), recurrent(coloured, 0),
        recurrent(synchronous, 0, {{"acceleration", 5}}), recurrent(wavefront, 0, {{"acceleration", 5}})}) {
    Simulation simulation = simulate(net, integrator, 0.05);
    simulation.step();
    simulation.step();
    const std::uint64_t before = allocations.load();
    for (int i = 0; i < 5; ++i) simulation.step();
    CHECK(allocations.load() - before == 0);
  }
  // Plugins count as well: an integrator that is made allocates its buffers.
  const std::uint64_t before = allocations.load();
  Simulation simulation = simulate(net, recurrent(synchronous, 0), 0.05);
  simulation.step();
  CHECK(allocations.load() > before);
}
