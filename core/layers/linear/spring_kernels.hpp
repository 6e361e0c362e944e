// Inner loops of the matrix-free solver: products with the stiffness of springs that are not assembled, over vectors
// with all nodes' components of one axis side by side. Compiled once for each instruction set; all give the same bits.
#pragma once

#include <cstddef>

#include "layers/kernels.hpp"

namespace springnet::layers {

// The stiffness of some springs, a I + q q^T each, [spring]. Single precision changes a spring's stiffness by less than
// 1e-7 of itself, and so every product of a positive definite net.
struct SpringStiffness {
  const float *a, *qx, *qy, *qz;
};

struct SpringKernels {
  // Vectors x end with eight numbers more than they need, and so do the arrays of stiffness; y += B (x_first -
  // x_second) for the first ends of a segment's springs, minus that for the second ends if `to_second`.
  void (*product)(const SegmentSprings& springs, const SpringStiffness& stiffness, const double* const x[3],
                  bool to_second, double* const y[3]);
  // z = D r; d: xx, yy, zz, xy, yz, xz, [count] each, as all arrays.
  void (*diagonal)(const double* const d[6], const double* const r[3], std::size_t count, double* const z[3]);
  double (*dot)(const double* a, const double* b, std::size_t count);
  // Sum of w a^2.
  double (*square)(const double* w, const double* a, std::size_t count);
  // y += s x, and y = x + s y.
  void (*add)(double s, const double* x, std::size_t count, double* y);
  void (*scale_add)(double s, const double* x, std::size_t count, double* y);
  // y = w x.
  void (*multiply)(const double* w, const double* x, std::size_t count, double* y);
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
