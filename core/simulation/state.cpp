#include "simulation/state.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>
#include <utility>

#include <springnet/huge_pages.hpp>

#include "constraints/vectors.hpp"

namespace springnet {

std::uint32_t pitch_of(std::uint32_t nodes) noexcept { return (nodes + 7) / 8 * 8 + 24; }

namespace {

// Whether all numbers of arrays are finite: 0 times infinity or nan is not 0. Several sums, so that the loop
// vectorises.
bool all_finite(const springnet_vectors& vectors, std::uint32_t count) noexcept {
  constexpr std::uint32_t lanes = 8;
  double sums[lanes] = {};
  for (const double* values : {vectors.x, vectors.y, vectors.z}) {
    std::uint32_t i = 0;
    for (; i + lanes <= count; i += lanes)
      for (std::uint32_t lane = 0; lane < lanes; ++lane) sums[lane] += values[i + lane] * 0.0;
    for (; i < count; ++i) sums[0] += values[i] * 0.0;
  }
  double sum = 0.0;
  for (const double each : sums) sum += each;
  return sum == 0.0;
}

// Zeros, from the system where they are many: those are written when the first sweep does, by its threads.
double* zeros(std::size_t count) {
  void* const block = std::calloc(count, sizeof(double));
  if (block == nullptr) throw std::bad_alloc();
  prefer_huge_pages(block, count * sizeof(double));
  return static_cast<double*>(block);
}

}  // namespace

State::State(std::uint32_t nodes, std::uint64_t internal_numbers)
    : memory(zeros(9 * std::size_t{pitch_of(nodes)} + internal_numbers), std::free),
      node_count(nodes),
      internal_count(internal_numbers) {
  restore_view();
}

void State::restore_view() noexcept {
  view.struct_size = sizeof view;
  const std::size_t pitch = pitch_of(node_count);
  double* at = memory.get();
  for (springnet_vectors* vectors : {&view.position, &view.velocity, &view.force}) {
    *vectors = {at, at + pitch, at + 2 * pitch};
    at += 3 * pitch;
  }
  view.internal = internal_count > 0 ? at : nullptr;
  internal.values = view.internal;
}

std::uint32_t State::first_not_finite() const noexcept {
  if (all_finite(view.position, node_count) && all_finite(view.velocity, node_count)) return node_count;
  std::uint32_t k = 0;
  for (; k < node_count; ++k) {
    const auto finite = [k](const springnet_vectors& v) {
      return std::isfinite(v.x[k]) && std::isfinite(v.y[k]) && std::isfinite(v.z[k]);
    };
    if (!finite(view.position) || !finite(view.velocity)) break;
  }
  return k;
}

bool State::internal_finite() const noexcept {
  return std::all_of(view.internal, view.internal + internal_count, [](double z) { return std::isfinite(z); });
}

bool State::forces_finite() const noexcept { return all_finite(view.force, node_count); }

void State::swap(State& other) noexcept {
  std::swap(view, other.view);
  memory.swap(other.memory);
  std::swap(internal.values, other.internal.values);
}

layers::NodeArrays State::nodes() const noexcept {
  return node_arrays(read_only(view.position), read_only(view.velocity), internal);
}

}  // namespace springnet
