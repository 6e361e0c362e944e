// Positions, velocities and forces of all nodes, in memory that the host owns.
#pragma once

#include <cstdint>
#include <memory>

#include <springnet/sdk/plugin.h>

#include "layers/internal.hpp"
#include "layers/kernels.hpp"

namespace springnet {

// Integrators see `view`.
struct State {
  springnet_state view{};
  std::unique_ptr<double[], void (*)(void*)> memory;
  std::uint32_t node_count;
  std::uint64_t internal_count;
  layers::InternalView internal;  // the laws' states of `view`

  State(std::uint32_t nodes, std::uint64_t internal_numbers);
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  // Exchanges the contents; both views stay valid.
  void swap(State& other) noexcept;
  // Points `view` at the memory again, after an integrator may have written into it.
  void restore_view() noexcept;
  // The first node whose position or velocity is not finite; the number of nodes if there is none.
  [[nodiscard]] std::uint32_t first_not_finite() const noexcept;
  [[nodiscard]] bool forces_finite() const noexcept;
  [[nodiscard]] bool internal_finite() const noexcept;
  [[nodiscard]] layers::NodeArrays nodes() const noexcept;
  [[nodiscard]] layers::ForceArrays forces() const noexcept { return {view.force.x, view.force.y, view.force.z}; }
};

// Distance between the arrays of two coordinates, in numbers. Not a multiple of a page, or the three coordinates of a
// node would compete for the same cache sets.
[[nodiscard]] std::uint32_t pitch_of(std::uint32_t nodes) noexcept;

[[nodiscard]] inline layers::NodeArrays node_arrays(const springnet_const_vectors& p, const springnet_const_vectors& v,
                                                    const layers::InternalView& internal) {
  return {p.x, p.y, p.z, v.x, v.y, v.z, &internal};
}

}  // namespace springnet
