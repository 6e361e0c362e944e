// Included once for each instruction set with KERNEL_NAMESPACE defined. Plain loops only: the linker could pick an
// inline library function compiled here, for a wider instruction set, for the whole program.

#include "layers/linear/block_kernels.hpp"

namespace springnet::layers::KERNEL_NAMESPACE {
namespace {

// Four numbers, on any boundary. Every operation is one on each number by itself, so that all sets give the same bits.
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));

[[gnu::always_inline]] inline Four load(const double* values) { return *reinterpret_cast<const Four*>(values); }
[[gnu::always_inline]] inline void store_three(const Four& value, double* out) {
  out[0] = value[0];
  out[1] = value[1];
  out[2] = value[2];
}

// Sum of blocks [begin, end) times the vectors of their columns; the fourth number is not used.
[[gnu::always_inline]] inline Four row_product(const BlockArrays& a, std::size_t begin, std::size_t end,
                                               const double* x) {
  Four first = {}, second = {}, third = {};
  for (std::size_t b = begin; b < end; ++b) {
    const double* block = a.values + 9 * b;
    const double* of = x + 3 * static_cast<std::size_t>(a.column[b]);
    first += load(block) * of[0];
    second += load(block + 3) * of[1];
    third += load(block + 6) * of[2];
  }
  return (first + second) + third;
}

[[gnu::always_inline]] inline Four block_product(const double* block, const Four& x) {
  return (load(block) * x[0] + load(block + 3) * x[1]) + load(block + 6) * x[2];
}

void product(const BlockArrays& arrays, NodeRange rows, const double* x, double* y) {
  const BlockArrays a = arrays;
  for (std::size_t k = rows.begin; k < rows.end; ++k)
    store_three(row_product(a, a.start[k], a.start[k + 1], x), y + 3 * k);
}

void diagonal(const double* blocks, NodeRange nodes, const double* r, double* z) {
  for (std::size_t k = nodes.begin; k < nodes.end; ++k)
    store_three(block_product(blocks + 9 * k, load(r + 3 * k)), z + 3 * k);
}

void lower(const BlockArrays& arrays, NodeRange rows, const double* r, double* z) {
  const BlockArrays a = arrays;
  for (std::size_t k = rows.begin; k < rows.end; ++k)
    store_three(load(r + 3 * k) - row_product(a, a.start[k], a.start[k + 1], z), z + 3 * k);
}

void upper(const BlockArrays& arrays, const double* blocks, NodeRange rows, double* z) {
  const BlockArrays a = arrays;
  for (std::size_t k = rows.end; k-- > rows.begin;) {
    const Four rest = load(z + 3 * k) - row_product(a, a.start[k], a.start[k + 1], z);
    store_three(block_product(blocks + 9 * k, rest), z + 3 * k);
  }
}

[[gnu::always_inline]] inline double total(const Four& a, const Four& b) {
  const Four sum = a + b;
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

double dot(const double* a, const double* b, NodeRange nodes) {
  Four even = {}, odd = {};
  std::size_t i = 3 * nodes.begin;
  const std::size_t end = 3 * nodes.end;
  for (; i + 8 <= end; i += 8) {
    even += load(a + i) * load(b + i);
    odd += load(a + i + 4) * load(b + i + 4);
  }
  double rest = 0.0;
  for (; i < end; ++i) rest += a[i] * b[i];
  return total(even, odd) + rest;
}

double square(const double* weight, const double* a, NodeRange nodes) {
  Four even = {}, odd = {};
  std::size_t k = nodes.begin;
  const auto weighted = [&](std::size_t node) {
    const Four value = load(a + 3 * node);
    return value * value * weight[node];
  };
  for (; k + 2 <= nodes.end; k += 2) {
    even += weighted(k);
    odd += weighted(k + 1);
  }
  if (k < nodes.end) even += weighted(k);
  const Four sum = even + odd;
  return (sum[0] + sum[1]) + sum[2];
}

void add(double s, const double* __restrict x, NodeRange nodes, double* __restrict y) {
  for (std::size_t i = 3 * nodes.begin; i < 3 * nodes.end; ++i) y[i] += s * x[i];
}

void scale_add(double s, const double* __restrict x, NodeRange nodes, double* __restrict y) {
  for (std::size_t i = 3 * nodes.begin; i < 3 * nodes.end; ++i) y[i] = x[i] + s * y[i];
}

}  // namespace

const BlockKernels& block_kernels() {
  static constexpr BlockKernels table{product, diagonal, lower, upper, dot, square, add, scale_add};
  return table;
}

}  // namespace springnet::layers::KERNEL_NAMESPACE
