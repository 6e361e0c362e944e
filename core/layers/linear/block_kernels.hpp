// Inner loops of the iterative solver, over vectors with the three components of a node side by side and over blocks
// of 3 x 3 numbers, column by column. Compiled once for each instruction set; all give the same bits. Arrays end with
// one number more than they need, because four are read at a time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layers/instruction_set.hpp"
#include "layers/linear/node_range.hpp"

namespace springnet::layers {

// Blocks of some rows: those of row k are [start[k], start[k + 1]).
struct BlockArrays {
  const std::uint32_t* start;
  const std::uint32_t* column;  // [block] node
  const double* values;         // [block][9]
};

struct BlockKernels {
  // y = A x for some rows.
  void (*product)(const BlockArrays& a, NodeRange rows, const double* x, double* y);
  // z = D r with a block a node.
  void (*diagonal)(const double* blocks, NodeRange nodes, const double* r, double* z);
  // Solves L z = r with a unit diagonal, then D^-1 U x = z in place, for rows of one piece. `blocks` are the inverse
  // diagonal blocks of U.
  void (*lower)(const BlockArrays& l, NodeRange rows, const double* r, double* z);
  void (*upper)(const BlockArrays& u, const double* blocks, NodeRange rows, double* z);
  // Sum of a b, and of weight |a|^2 with one weight a node.
  double (*dot)(const double* a, const double* b, NodeRange nodes);
  double (*square)(const double* weight, const double* a, NodeRange nodes);
  // y += s x.
  void (*add)(double s, const double* x, NodeRange nodes, double* y);
  // y = x + s y.
  void (*scale_add)(double s, const double* x, NodeRange nodes, double* y);
};

namespace generic {
const BlockKernels& block_kernels();
}
namespace avx2 {
const BlockKernels& block_kernels();
}
namespace avx512 {
const BlockKernels& block_kernels();
}

// The kernels of an available set.
[[nodiscard]] const BlockKernels& block_kernels_for(InstructionSet set);

}  // namespace springnet::layers
