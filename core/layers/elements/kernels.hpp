// Inner loops over a batch of elements of one invariant: values, rates and gradients from the nodes' positions and
// velocities, and forces on the corners. Compiled once for each instruction set, as those of springs.
#pragma once

#include <cstddef>
#include <cstdint>

namespace springnet::layers {

struct NodeArrays;

// Most elements of a batch: its geometry fits the first-level cache, and the calls of its laws cost little an element.
inline constexpr std::size_t element_batch = 128;

// Elements of one invariant by their corners.
struct BatchCorners {
  const std::uint32_t* corner[4];  // [count] nodes; the last is not read for elements of three nodes
  const double* reference;         // [count]
  std::size_t count;
};

struct alignas(64) BatchGeometry {
  double value[element_batch];         // q as laws read it: see nearest_turn()
  double rate[element_batch];          // q'
  double gradient[12][element_batch];  // dq/dp: [3 corner + coordinate]
};

// Where forces on corners are written, N: those of corner i from i * pitch on.
struct CornerForces {
  double *x, *y, *z;
  std::size_t pitch;
};

struct ElementKernels {
  using Geometry = void (*)(const BatchCorners& corners, const NodeArrays& nodes, BatchGeometry& out);
  Geometry angles, dihedrals, areas, volumes;
  // -(q_1 + q_2) dq/dp for each corner; q_1, q_2: generalised forces of the laws, null for a law that there is not.
  void (*forces)(const BatchGeometry& geometry, std::size_t corner_count, std::size_t count, const double* q_1,
                 const double* q_2, const CornerForces& out);
};

}  // namespace springnet::layers
