// Inner loops of the matrix-free solver: products with the stiffness of springs that are not assembled. Vectors have
// four numbers a node, x, y, z and 0, so that one load has all of a node. Compiled once for each instruction set; all
// give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layers/linear/node_range.hpp"
#include "layers/linear/team.hpp"

namespace springnet::layers {

// Springs by their first nodes: those of node k are start[k - begin] to start[k - begin + 1], of nodes from `begin` on.
// Stiffness: a I + q q^T each, [spring][4] q and a. Single precision changes a spring's stiffness by less than 1e-7 of
// itself, and so every product of a positive definite net.
struct SpringRows {
  const std::uint32_t* start;
  const std::uint32_t* second;
  const float* stiffness;
};

struct SpringKernels {
  // y += B (x_first - x_second) for the first ends of the springs of some nodes, minus that for the second ends if
  // `to_second`.
  void (*product)(const SpringRows& springs, NodeRange nodes, const double* x, bool to_second, double* y);
  // z = D r of some nodes; D: [node][3][4], three columns.
  void (*diagonal)(const float* d, NodeRange nodes, const double* r, double* z);
  void (*diagonal_double)(const double* d, NodeRange nodes, const double* r, double* z);
  double (*dot)(const double* a, const double* b, std::size_t count);
  // Sum of w a^2 of some nodes; w: [node].
  double (*square)(const double* w, const double* a, NodeRange nodes);
  // y += w x of some nodes; answers x.y.
  double (*add_and_dot)(const double* w, const double* x, NodeRange nodes, double* y);
  // y = x + s y.
  void (*scale_add)(double s, const double* x, std::size_t count, double* y);
  // x += s p, r -= s q, z = D r of some nodes; answers r.z and the sum of w r^2.
  Sums2 (*advance)(double s, const double* p, const double* q, const float* d, const double* w, NodeRange nodes,
                   double* x, double* r, double* z);
};

namespace generic {
const SpringKernels& spring_kernels();
}
namespace avx2 {
const SpringKernels& spring_kernels();
}
namespace avx512 {
const SpringKernels& spring_kernels();
}

}  // namespace springnet::layers
