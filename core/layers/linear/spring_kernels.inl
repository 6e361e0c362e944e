// Included once for each instruction set with KERNEL_NAMESPACE defined. Loops over nodes use the compilers' vectors of
// four numbers, which mean the same for every instruction set; the others are plain.

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include <cstring>

#include "layers/linear/spring_kernels.hpp"

#define RESTRICT __restrict

namespace springnet::layers::KERNEL_NAMESPACE {
namespace {

using Four = double __attribute__((vector_size(32)));
using FourFloats = float __attribute__((vector_size(16)));

// Into a variable, for functions that return such vectors differ between instruction sets.
[[gnu::always_inline]] inline void load(const double* from, Four& to) { std::memcpy(&to, from, sizeof to); }
[[gnu::always_inline]] inline void load(const float* from, Four& to) {
#if defined(__AVX__)
  to = _mm256_cvtps_pd(_mm_loadu_ps(from));  // which GCC 12 does not find
#else
  FourFloats values;
  std::memcpy(&values, from, sizeof values);
  to = __builtin_convertvector(values, Four);
#endif
}
[[gnu::always_inline]] inline void store(const Four& from, double* to) { std::memcpy(to, &from, sizeof from); }

template <bool to_second>
[[gnu::always_inline]] inline void product_of(const SpringRows& springs, NodeRange nodes, const double* x, double* y) {
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    const std::size_t begin = springs.start[k - nodes.begin], end = springs.start[k - nodes.begin + 1];
    if (begin == end) continue;
    Four here, sum{};
    load(x + 4 * k, here);
    for (std::size_t s = begin; s < end; ++s) {
      const std::size_t j = springs.second[s];
      Four there, q;
      load(x + 4 * j, there);
      load(springs.stiffness + 4 * s, q);
      const double a = q[3];
      q[3] = 0.0;
      const Four d = here - there, terms = q * d;
      const double along = terms[0] + terms[1] + terms[2];
      const Four force = a * d + along * q;
      sum += force;
      if constexpr (to_second) {
        Four other;
        load(y + 4 * j, other);
        other -= force;
        store(other, y + 4 * j);
      }
    }
    Four own;
    load(y + 4 * k, own);
    own += sum;
    store(own, y + 4 * k);
  }
}

void product(const SpringRows& springs, NodeRange nodes, const double* x, bool to_second, double* y) {
  if (to_second)
    product_of<true>(springs, nodes, x, y);
  else
    product_of<false>(springs, nodes, x, y);
}

template <class Number>
[[gnu::always_inline]] inline void diagonal_of(const Number* d, NodeRange nodes, const double* r, double* z) {
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    Four first, second, third;
    load(d + 12 * k, first);
    load(d + 12 * k + 4, second);
    load(d + 12 * k + 8, third);
    const Four sum = first * r[4 * k] + second * r[4 * k + 1] + third * r[4 * k + 2];
    store(sum, z + 4 * k);
  }
}
void diagonal(const float* d, NodeRange nodes, const double* r, double* z) { diagonal_of(d, nodes, r, z); }
void diagonal_double(const double* d, NodeRange nodes, const double* r, double* z) { diagonal_of(d, nodes, r, z); }

// Sums in eight parts, each of every eighth term, so that all instruction sets add alike.
constexpr std::size_t parts = 8;

[[gnu::always_inline]] inline double total(const double (&sum)[parts]) {
  return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

// The same of vectors.
[[gnu::always_inline]] inline double total(const Four (&sum)[2]) {
  return ((sum[0][0] + sum[1][0]) + (sum[0][1] + sum[1][1])) + (sum[0][2] + sum[1][2]);
}

double dot(const double* RESTRICT a, const double* RESTRICT b, std::size_t count) {
  double sum[parts] = {};
  std::size_t i = 0;
  for (; i + parts <= count; i += parts)
    for (std::size_t p = 0; p < parts; ++p) sum[p] += a[i + p] * b[i + p];
  for (std::size_t p = 0; i < count; ++i, ++p) sum[p] += a[i] * b[i];
  return total(sum);
}

double square(const double* RESTRICT w, const double* RESTRICT a, NodeRange nodes) {
  Four sums[2]{};
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    Four there;
    load(a + 4 * k, there);
    sums[k % 2] += w[k] * (there * there);
  }
  return total(sums);
}

double add_and_dot(const double* RESTRICT w, const double* RESTRICT x, NodeRange nodes, double* RESTRICT y) {
  Four sums[2]{};
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    Four there, result;
    load(x + 4 * k, there);
    load(y + 4 * k, result);
    result += w[k] * there;
    store(result, y + 4 * k);
    sums[k % 2] += there * result;
  }
  return total(sums);
}

void scale_add(double s, const double* RESTRICT x, std::size_t count, double* RESTRICT y) {
  for (std::size_t i = 0; i < count; ++i) y[i] = x[i] + s * y[i];
}

Sums2 advance(double s, const double* RESTRICT p, const double* RESTRICT q, const float* RESTRICT d,
              const double* RESTRICT w, NodeRange nodes, double* RESTRICT x, double* RESTRICT r, double* RESTRICT z) {
  Four along[2]{}, square[2]{};
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    const std::size_t i = 4 * k;
    Four direction, image, place, left, first, second, third;
    load(p + i, direction);
    load(x + i, place);
    place += s * direction;
    store(place, x + i);
    load(q + i, image);
    load(r + i, left);
    left -= s * image;
    store(left, r + i);
    load(d + 12 * k, first);
    load(d + 12 * k + 4, second);
    load(d + 12 * k + 8, third);
    const Four preconditioned = first * left[0] + second * left[1] + third * left[2];
    store(preconditioned, z + i);
    along[k % 2] += left * preconditioned;
    square[k % 2] += w[k] * (left * left);
  }
  return {total(along), total(square)};
}

}  // namespace

const SpringKernels& spring_kernels() {
  static constexpr SpringKernels table{product, diagonal,    diagonal_double, dot,
                                       square,  add_and_dot, scale_add,       advance};
  return table;
}

}  // namespace springnet::layers::KERNEL_NAMESPACE
