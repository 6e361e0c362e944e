// Inner loops of what goes over springs without a matrix: products with their stiffness, and steps of conjugate
// gradients in single precision. Vectors have four numbers a node, x, y, z and one of no meaning (finite
// in x of products), so that one load has all of a node. Compiled once for each instruction set; all give the same
// bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layers/instruction_set.hpp"
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

// The same with the derivatives of axial springs (springs/blocks.hpp), K = T' n n^T + a (I - n n^T) + T_u n w^T and
// D = T_u n n^T: [spring][8] n, a, w and T_u; and T' by themselves.
struct AxialRows {
  const std::uint32_t* start;
  const std::uint32_t* second;
  const double* values;
  const double* by_length;
};

// Springs as their laws answer, [spring]: unit vectors along each, lengths and rates of length, directions and speeds
// of relative motion, and of two laws, null: there is none, tension, dT/dl and dT/du.
struct AxialAnswers {
  const std::uint32_t* spring;  // no_spring: there is none
  const std::uint32_t* place;
  std::size_t count;
  const double *normal[3], *along[3];
  const double *length, *rate, *speed;
  const double *tension[2], *by_length[2], *by_rate[2];
};

// Greatest number in single precision whose products are still finite.
inline constexpr double greatest_in_single = 1e18;

// Of springs: squared norms of the antisymmetric part and of the whole; whether none softens (its q would not be real),
// and none exceeds greatest_in_single.
struct StiffnessSums {
  double asymmetric = 0.0, all = 0.0;
  bool fits = true;
};

// All answer sums over some nodes.
struct SpringKernels {
  // y += B (x_first - x_second) for the first ends of the springs of some nodes, minus that for the second ends if
  // `to_second`.
  void (*product)(const SpringRows& springs, NodeRange nodes, const float* x, bool to_second, float* y);
  void (*product_double)(const SpringRows& springs, NodeRange nodes, const double* x, bool to_second, double* y);
  // y -= (velocity_weight D + position_weight K)^T (x_first - x_second), plus that for the second ends if `to_second`.
  void (*subtract_transposed)(const AxialRows& springs, NodeRange nodes, double velocity_weight, double position_weight,
                              const double* x, bool to_second, double* y);
  // y -= D (v_first - v_second) + K (p_first - p_second), plus that for the second ends if `to_second`.
  void (*subtract_product)(const AxialRows& springs, NodeRange nodes, const double* p, const double* v, bool to_second,
                           double* y);
  // Writes derivatives of springs where they lie (AxialRows). Answers whether all of them are finite.
  bool (*write_axial)(const AxialAnswers& answers, double* values, double* by_length);
  // Writes a I + q q^T = position_weight K + velocity_weight D, without the part T_u n w^T, of springs where they lie
  // (SpringRows); NaN for springs that do not fit, see StiffnessSums.
  StiffnessSums (*write_stiffness)(const AxialAnswers& answers, double position_weight, double velocity_weight,
                                   float* stiffness);
  // Adds a I + q q^T of the springs of some nodes to the blocks of their first ends, and of their second ends if
  // `to_second`: [node][8] xx, yy, zz, one of no meaning, xy, yz, zx, another.
  void (*add_blocks)(const SpringRows& springs, NodeRange nodes, bool to_second, double* blocks);
  // Of nodes with scales ([node][3], the second and third of which count by their weights): x = first scale times w, y
  // = the others times w; w has x of all nodes first, `count` of them.
  void (*spread)(const double* scales, double second_weight, double third_weight, std::size_t count, const double* w,
                 double* x, double* y);
  // Back into the order of w: the first three numbers of each node.
  void (*gather)(const double* y, std::size_t count, double* w);
  // z = D r; D: [node][3][4], three columns.
  void (*diagonal)(const float* d, NodeRange nodes, const float* r, float* z);
  void (*diagonal_double)(const double* d, NodeRange nodes, const double* r, double* z);
  double (*dot)(const float* a, const float* b, NodeRange nodes);
  // Sum of w a^2; w: [node].
  double (*square)(const float* w, const float* a, NodeRange nodes);
  // y += w x; answers x.y.
  double (*add_and_dot)(const float* w, const float* x, NodeRange nodes, float* y);
  // y += s x.
  void (*add)(float s, const float* x, NodeRange nodes, float* y);
  // y = x + s y.
  void (*scale_add)(float s, const float* x, NodeRange nodes, float* y);
  // x += s p, r -= s q, z = D r; answers r.z and the sum of w r^2.
  Sums2 (*advance)(float s, const float* p, const float* q, const float* d, const float* w, NodeRange nodes, float* x,
                   float* r, float* z);
  // x = L^-T L^-1 x, of numbers in sixteens. lower, upper: [column][size] of L and of L^T beside their diagonal, 0
  // elsewhere; inverse: of the diagonal.
  void (*substitute)(const float* lower, const float* upper, const float* inverse, std::size_t size, float* x);
};

// The fastest ones that an instruction set has.
[[nodiscard]] const SpringKernels& spring_kernels_for(InstructionSet set);

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
