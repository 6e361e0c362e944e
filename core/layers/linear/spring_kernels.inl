// Included once for each instruction set with KERNEL_NAMESPACE defined. Loops over nodes use the compilers' vectors of
// four numbers, which mean the same for every instruction set; the others are plain.

#include <cstring>

#include "layers/kernels.hpp"
#include "layers/linear/spring_kernels.hpp"

#define RESTRICT __restrict

namespace springnet::layers::KERNEL_NAMESPACE {
namespace {

using FourDoubles = double __attribute__((vector_size(32)));
using FourFloats = float __attribute__((vector_size(16)));
using EightFloats = float __attribute__((vector_size(32)));
template <class Number>
struct VectorOf;
template <>
struct VectorOf<double> {
  using Four = FourDoubles;
};
template <>
struct VectorOf<float> {
  using Four = FourFloats;
};
template <class Number>
using FourOf = typename VectorOf<Number>::Four;

// Into a variable, for functions that return such vectors differ between instruction sets.
[[gnu::always_inline]] inline void load(const double* from, FourDoubles& to) { std::memcpy(&to, from, sizeof to); }
[[gnu::always_inline]] inline void load(const float* from, FourFloats& to) { std::memcpy(&to, from, sizeof to); }
[[gnu::always_inline]] inline void load(const float* from, FourDoubles& to) {
  FourFloats values;
  load(from, values);
  to = __builtin_convertvector(values, FourDoubles);
}
[[gnu::always_inline]] inline void store(const FourDoubles& from, double* to) { std::memcpy(to, &from, sizeof from); }
[[gnu::always_inline]] inline void store(const FourFloats& from, float* to) { std::memcpy(to, &from, sizeof from); }

// What a spring's first end feels; the fourth number is of no use.
template <class Number>
[[gnu::always_inline]] inline void force_of(const FourOf<Number>& d, const FourOf<Number>& q, FourOf<Number>& force) {
  const FourOf<Number> terms = q * d;
  const Number a = q[3], along = terms[0] + terms[1] + terms[2];
  force = a * d + along * q;
}
template <class Number>
[[gnu::always_inline]] inline void subtract(const FourOf<Number>& force, Number* y) {
  FourOf<Number> there;
  load(y, there);
  there -= force;
  store(there, y);
}

// Springs of a node two by two, from `s` on.
template <bool to_second>
[[gnu::always_inline]] inline void add_pairs(const SpringRows& springs, const float* x, const FourFloats& here,
                                             std::size_t& s, std::size_t end, float* y, FourFloats& sum) {
  EightFloats both{};
  const EightFloats from = __builtin_shufflevector(here, here, 0, 1, 2, 3, 4, 5, 6, 7);
  for (; s + 2 <= end; s += 2) {
    const std::size_t i = springs.second[s], j = springs.second[s + 1];
    FourFloats one, other;
    EightFloats q;
    load(x + 4 * i, one);
    load(x + 4 * j, other);
    std::memcpy(&q, springs.stiffness + 4 * s, sizeof q);
    const EightFloats d = from - __builtin_shufflevector(one, other, 0, 1, 2, 3, 4, 5, 6, 7), terms = q * d;
    const EightFloats along = __builtin_shufflevector(terms, terms, 0, 0, 0, 0, 4, 4, 4, 4) +
                              __builtin_shufflevector(terms, terms, 1, 1, 1, 1, 5, 5, 5, 5) +
                              __builtin_shufflevector(terms, terms, 2, 2, 2, 2, 6, 6, 6, 6);
    const EightFloats force = __builtin_shufflevector(q, q, 3, 3, 3, 3, 7, 7, 7, 7) * d + along * q;
    both += force;
    if constexpr (to_second) {
      subtract<float>(__builtin_shufflevector(force, force, 0, 1, 2, 3), y + 4 * i);
      subtract<float>(__builtin_shufflevector(force, force, 4, 5, 6, 7), y + 4 * j);
    }
  }
  sum += __builtin_shufflevector(both, both, 0, 1, 2, 3) + __builtin_shufflevector(both, both, 4, 5, 6, 7);
}
template <bool to_second>
[[gnu::always_inline]] inline void add_pairs(const SpringRows&, const double*, const FourDoubles&, std::size_t&,
                                             std::size_t, double*, FourDoubles&) {}

template <bool to_second, class Number>
[[gnu::always_inline]] inline void product_of(const SpringRows& rows, NodeRange nodes, const Number* x, Number* y) {
  const SpringRows springs = rows;
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    std::size_t s = springs.start[k - nodes.begin];
    const std::size_t end = springs.start[k - nodes.begin + 1];
    if (s == end) continue;
    FourOf<Number> here, sum{};
    load(x + 4 * k, here);
    add_pairs<to_second>(springs, x, here, s, end, y, sum);
    for (; s < end; ++s) {
      const std::size_t j = springs.second[s];
      FourOf<Number> there, q, force;
      load(x + 4 * j, there);
      load(springs.stiffness + 4 * s, q);
      force_of<Number>(here - there, q, force);
      sum += force;
      if constexpr (to_second) subtract<Number>(force, y + 4 * j);
    }
    FourOf<Number> own;
    load(y + 4 * k, own);
    own += sum;
    store(own, y + 4 * k);
  }
}

void product(const SpringRows& springs, NodeRange nodes, const float* x, bool to_second, float* y) {
  if (to_second)
    product_of<true>(springs, nodes, x, y);
  else
    product_of<false>(springs, nodes, x, y);
}
void product_double(const SpringRows& springs, NodeRange nodes, const double* x, bool to_second, double* y) {
  if (to_second)
    product_of<true>(springs, nodes, x, y);
  else
    product_of<false>(springs, nodes, x, y);
}

// A number in all places: loaded so, it takes no time to be moved there.
[[gnu::always_inline]] inline void spread(const double& from, FourDoubles& to) {
  to = FourDoubles{from, from, from, from};
}

// With d = x_first - x_second and s = n.d a spring adds
//   p a d + (p (T' - a) + v T_u) s n + p T_u s w,   p and v the weights of K and D.
template <bool to_second>
[[gnu::always_inline]] inline void subtract_transposed_of(const AxialRows& rows, NodeRange nodes,
                                                          double velocity_weight, double position_weight,
                                                          const double* x, double* y) {
  const AxialRows springs = rows;
  FourDoubles v, p;
  spread(velocity_weight, v);
  spread(position_weight, p);
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    const std::size_t begin = springs.start[k - nodes.begin], end = springs.start[k - nodes.begin + 1];
    if (begin == end) continue;
    FourDoubles here, own, sum{};
    load(x + 4 * k, here);
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t j = springs.second[i];
      const double* const values = springs.values + 8 * i;
      FourDoubles there, normal, across, a, by_rate, by_length;
      load(x + 4 * j, there);
      load(values, normal);
      load(values + 4, across);
      spread(values[3], a);
      spread(values[7], by_rate);
      spread(springs.by_length[i], by_length);
      const FourDoubles d = here - there, terms = normal * d,
                        s = __builtin_shufflevector(terms, terms, 0, 0, 0, 0) +
                            __builtin_shufflevector(terms, terms, 1, 1, 1, 1) +
                            __builtin_shufflevector(terms, terms, 2, 2, 2, 2);
      const FourDoubles force = p * a * d + (p * (by_length - a) + v * by_rate) * s * normal + p * by_rate * s * across;
      sum += force;
      if constexpr (to_second) {
        FourDoubles other;
        load(y + 4 * j, other);
        other += force;
        store(other, y + 4 * j);
      }
    }
    load(y + 4 * k, own);
    own -= sum;
    store(own, y + 4 * k);
  }
}

void subtract_transposed(const AxialRows& springs, NodeRange nodes, double velocity_weight, double position_weight,
                         const double* x, bool to_second, double* y) {
  if (to_second)
    subtract_transposed_of<true>(springs, nodes, velocity_weight, position_weight, x, y);
  else
    subtract_transposed_of<false>(springs, nodes, velocity_weight, position_weight, x, y);
}

// With d = p_first - p_second, e = v_first - v_second and s = n.d a spring adds
//   a d + ((T' - a) s + T_u (w.d + n.e)) n.
template <bool to_second>
[[gnu::always_inline]] inline void subtract_product_of(const AxialRows& rows, NodeRange nodes, const double* p,
                                                       const double* v, double* y) {
  const AxialRows springs = rows;
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    const std::size_t begin = springs.start[k - nodes.begin], end = springs.start[k - nodes.begin + 1];
    if (begin == end) continue;
    FourDoubles place, speed, own, sum{};
    load(p + 4 * k, place);
    load(v + 4 * k, speed);
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t j = springs.second[i];
      const double* const values = springs.values + 8 * i;
      FourDoubles there, other, normal, across, a, by_rate, by_length;
      load(p + 4 * j, there);
      load(v + 4 * j, other);
      load(values, normal);
      load(values + 4, across);
      spread(values[3], a);
      spread(values[7], by_rate);
      spread(springs.by_length[i], by_length);
      const FourDoubles d = place - there,
                        terms = (by_length - a) * normal * d + by_rate * (across * d + normal * (speed - other)),
                        s = __builtin_shufflevector(terms, terms, 0, 0, 0, 0) +
                            __builtin_shufflevector(terms, terms, 1, 1, 1, 1) +
                            __builtin_shufflevector(terms, terms, 2, 2, 2, 2);
      const FourDoubles force = a * d + s * normal;
      sum += force;
      if constexpr (to_second) {
        load(y + 4 * j, other);
        other += force;
        store(other, y + 4 * j);
      }
    }
    load(y + 4 * k, own);
    own -= sum;
    store(own, y + 4 * k);
  }
}

void subtract_product(const AxialRows& springs, NodeRange nodes, const double* p, const double* v, bool to_second,
                      double* y) {
  if (to_second)
    subtract_product_of<true>(springs, nodes, p, v, y);
  else
    subtract_product_of<false>(springs, nodes, p, v, y);
}

// In chunks that stay in the nearest cache: first what all springs have side by side, then each where it lies.
bool write_axial(const AxialAnswers& answers, double* values, double* by_length) {
  constexpr std::size_t chunk = 64;
  double share[chunk], across[3][chunk], stretch[chunk], drag[chunk];
  double left = 0.0;  // stays 0, unless a number is not finite
  for (std::size_t begin = 0; begin < answers.count; begin += chunk) {
    const std::size_t count = answers.count - begin < chunk ? answers.count - begin : chunk;
    const double* const RESTRICT length = answers.length + begin;
    for (std::size_t i = 0; i < count; ++i) share[i] = stretch[i] = drag[i] = 0.0;
    for (std::size_t law = 0; law < 2; ++law) {
      if (answers.tension[law] == nullptr) continue;
      const double *const RESTRICT
          tension = answers.tension[law] + begin,
          *const RESTRICT by_l = answers.by_length[law] + begin, *const RESTRICT by_u = answers.by_rate[law] + begin;
      for (std::size_t i = 0; i < count; ++i) {
        share[i] += tension[i];
        stretch[i] += by_l[i];
        drag[i] += by_u[i];
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const double *const RESTRICT normal = answers.normal[c] + begin, *const RESTRICT along = answers.along[c] + begin,
                                   *const RESTRICT rate = answers.rate + begin,
                                   *const RESTRICT speed = answers.speed + begin;
      for (std::size_t i = 0; i < count; ++i) across[c][i] = (speed[i] * along[i] - rate[i] * normal[i]) / length[i];
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (answers.spring[begin + i] == no_spring) continue;
      const double sum = share[i] + stretch[i] + drag[i];
      left += sum - sum;
      const std::size_t place = answers.place[begin + i];
      const bool has_length = length[i] > 0.0;
      const FourDoubles first{answers.normal[0][begin + i], answers.normal[1][begin + i], answers.normal[2][begin + i],
                              has_length ? share[i] / length[i] : 0.0};
      FourDoubles second{across[0][i], across[1][i], across[2][i], drag[i]};
      if (!has_length) second = FourDoubles{0.0, 0.0, 0.0, drag[i]};
      store(first, values + 8 * place);
      store(second, values + 8 * place + 4);
      by_length[place] = stretch[i];
    }
  }
  return left == 0.0;
}

StiffnessSums write_stiffness(const AxialAnswers& answers, double position_weight, double velocity_weight,
                              float* stiffness) {
  constexpr std::size_t chunk = 64;
  double share[chunk], along[chunk], root[chunk], skew[chunk];
  StiffnessSums sums;
  for (std::size_t begin = 0; begin < answers.count; begin += chunk) {
    const std::size_t count = answers.count - begin < chunk ? answers.count - begin : chunk;
    const double *const RESTRICT length = answers.length + begin, *const RESTRICT rate = answers.rate + begin,
                                 *const RESTRICT speed = answers.speed + begin;
    for (std::size_t i = 0; i < count; ++i) share[i] = along[i] = skew[i] = 0.0;
    for (std::size_t law = 0; law < 2; ++law) {
      if (answers.tension[law] == nullptr) continue;
      const double *const RESTRICT
          tension = answers.tension[law] + begin,
          *const RESTRICT by_l = answers.by_length[law] + begin, *const RESTRICT by_u = answers.by_rate[law] + begin;
      for (std::size_t i = 0; i < count; ++i) {
        share[i] += position_weight * tension[i];
        along[i] += position_weight * by_l[i] + velocity_weight * by_u[i];
        skew[i] += position_weight * by_u[i];
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const double across = speed[i] * speed[i] - rate[i] * rate[i];
      const double a = length[i] > 0.0 ? share[i] / length[i] : 0.0;
      const double turned = length[i] > 0.0 ? skew[i] / length[i] : 0.0;
      share[i] = a;
      along[i] -= a;
      root[i] = __builtin_sqrt(along[i] > 0.0 ? along[i] : 0.0);
      skew[i] = 2.0 * turned * turned * (across > 0.0 ? across : 0.0);
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (answers.spring[begin + i] == no_spring) continue;
      float* const to = stiffness + 4 * std::size_t{answers.place[begin + i]};
      const double a = share[i];
      const bool fits = along[i] >= 0.0 && along[i] <= greatest_in_single && __builtin_fabs(a) <= greatest_in_single;
      if (!fits) {
        sums.fits = false;
        store(FourFloats{} + __builtin_nanf(""), to);
        continue;
      }
      const FourDoubles all{root[i] * answers.normal[0][begin + i], root[i] * answers.normal[1][begin + i],
                            root[i] * answers.normal[2][begin + i], a};
      store(__builtin_convertvector(all, FourFloats), to);
      sums.asymmetric += skew[i];
      sums.all += 2.0 * a * a + (a + along[i]) * (a + along[i]);
    }
  }
  return sums;
}

template <bool to_second>
[[gnu::always_inline]] inline void add_blocks_of(const SpringRows& rows, NodeRange nodes, double* blocks) {
  const SpringRows springs = rows;
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    const std::size_t begin = springs.start[k - nodes.begin], end = springs.start[k - nodes.begin + 1];
    if (begin == end) continue;
    FourDoubles diagonal{}, beside{}, there;
    for (std::size_t i = begin; i < end; ++i) {
      FourDoubles q;
      load(springs.stiffness + 4 * i, q);
      const double a = q[3];
      const FourDoubles squares = q * q + a, products = q * __builtin_shufflevector(q, q, 1, 2, 0, 3);
      diagonal += squares;
      beside += products;
      if constexpr (to_second) {
        double* const other = blocks + 8 * std::size_t{springs.second[i]};
        load(other, there);
        there += squares;
        store(there, other);
        load(other + 4, there);
        there += products;
        store(there, other + 4);
      }
    }
    load(blocks + 8 * k, there);
    there += diagonal;
    store(there, blocks + 8 * k);
    load(blocks + 8 * k + 4, there);
    there += beside;
    store(there, blocks + 8 * k + 4);
  }
}

void add_blocks(const SpringRows& springs, NodeRange nodes, bool to_second, double* blocks) {
  if (to_second)
    add_blocks_of<true>(springs, nodes, blocks);
  else
    add_blocks_of<false>(springs, nodes, blocks);
}

// Four nodes at a time: rows of a square are numbers of four nodes, columns those of one.
[[gnu::always_inline]] inline void transpose(FourDoubles (&rows)[4]) {
  const FourDoubles a = __builtin_shufflevector(rows[0], rows[1], 0, 4, 2, 6),
                    b = __builtin_shufflevector(rows[0], rows[1], 1, 5, 3, 7),
                    c = __builtin_shufflevector(rows[2], rows[3], 0, 4, 2, 6),
                    d = __builtin_shufflevector(rows[2], rows[3], 1, 5, 3, 7);
  rows[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  rows[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  rows[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  rows[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

void spread_scaled(const double* scales, double second_weight, double third_weight, std::size_t count, const double* w,
                   double* x, double* y) {
  const auto one = [&](std::size_t k, const FourDoubles& node) {
    const double* const scale = scales + 3 * k;
    store(scale[0] * node, x + 4 * k);
    store((second_weight * scale[1] + third_weight * scale[2]) * node, y + 4 * k);
  };
  std::size_t k = 0;
  for (; k + 4 <= count; k += 4) {
    FourDoubles rows[4]{};
    for (std::size_t c = 0; c < 3; ++c) load(w + c * count + k, rows[c]);
    transpose(rows);
    for (std::size_t i = 0; i < 4; ++i) one(k + i, rows[i]);
  }
  for (; k < count; ++k) one(k, FourDoubles{w[k], w[count + k], w[2 * count + k], 0.0});
}

void gather(const double* y, std::size_t count, double* w) {
  std::size_t k = 0;
  for (; k + 4 <= count; k += 4) {
    FourDoubles rows[4];
    for (std::size_t i = 0; i < 4; ++i) load(y + 4 * (k + i), rows[i]);
    transpose(rows);
    for (std::size_t c = 0; c < 3; ++c) store(rows[c], w + c * count + k);
  }
  for (; k < count; ++k)
    for (std::size_t c = 0; c < 3; ++c) w[c * count + k] = y[4 * k + c];
}

template <class Number>
[[gnu::always_inline]] inline void times_columns(const Number* d, const FourOf<Number>& r, FourOf<Number>& z) {
  FourOf<Number> first, second, third;
  load(d, first);
  load(d + 4, second);
  load(d + 8, third);
  z = first * r[0] + second * r[1] + third * r[2];
}
template <class Number>
[[gnu::always_inline]] inline void diagonal_of(const Number* d, NodeRange nodes, const Number* r, Number* z) {
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    FourOf<Number> from, to;
    load(r + 4 * k, from);
    times_columns(d + 12 * k, from, to);
    store(to, z + 4 * k);
  }
}
void diagonal(const float* d, NodeRange nodes, const float* r, float* z) { diagonal_of(d, nodes, r, z); }
void diagonal_double(const double* d, NodeRange nodes, const double* r, double* z) { diagonal_of(d, nodes, r, z); }

// Sums over the nodes of a part in two vectors: single precision is enough for some hundred nodes.
[[gnu::always_inline]] inline double total(const FourFloats (&sum)[2]) {
  return ((double{sum[0][0]} + sum[1][0]) + (double{sum[0][1]} + sum[1][1])) + (double{sum[0][2]} + sum[1][2]);
}

double dot(const float* RESTRICT a, const float* RESTRICT b, NodeRange nodes) {
  FourFloats sums[2]{};
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    FourFloats left, right;
    load(a + 4 * k, left);
    load(b + 4 * k, right);
    sums[k % 2] += left * right;
  }
  return total(sums);
}

double square(const float* RESTRICT w, const float* RESTRICT a, NodeRange nodes) {
  FourFloats sums[2]{};
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    FourFloats there;
    load(a + 4 * k, there);
    sums[k % 2] += w[k] * (there * there);
  }
  return total(sums);
}

double add_and_dot(const float* RESTRICT w, const float* RESTRICT x, NodeRange nodes, float* RESTRICT y) {
  FourFloats sums[2]{};
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    FourFloats there, result;
    load(x + 4 * k, there);
    load(y + 4 * k, result);
    result += w[k] * there;
    store(result, y + 4 * k);
    sums[k % 2] += there * result;
  }
  return total(sums);
}

void add(float s, const float* RESTRICT x, NodeRange nodes, float* RESTRICT y) {
  for (std::size_t i = 4 * nodes.begin; i < 4 * nodes.end; ++i) y[i] += s * x[i];
}

void scale_add(float s, const float* RESTRICT x, NodeRange nodes, float* RESTRICT y) {
  for (std::size_t i = 4 * nodes.begin; i < 4 * nodes.end; ++i) y[i] = x[i] + s * y[i];
}

Sums2 advance(float s, const float* RESTRICT p, const float* RESTRICT q, const float* RESTRICT d,
              const float* RESTRICT w, NodeRange nodes, float* RESTRICT x, float* RESTRICT r, float* RESTRICT z) {
  FourFloats along[2]{}, square[2]{};
  for (std::size_t k = nodes.begin; k < nodes.end; ++k) {
    const std::size_t i = 4 * k;
    FourFloats direction, image, place, left, preconditioned;
    load(p + i, direction);
    load(x + i, place);
    place += s * direction;
    store(place, x + i);
    load(q + i, image);
    load(r + i, left);
    left -= s * image;
    store(left, r + i);
    times_columns(d + 12 * k, left, preconditioned);
    store(preconditioned, z + i);
    along[k % 2] += left * preconditioned;
    square[k % 2] += w[k] * (left * left);
  }
  return {total(along), total(square)};
}

void subtract_column(float s, const float* __restrict column, std::size_t begin, std::size_t end, float* __restrict x) {
  for (std::size_t i = begin; i < end; i += 16)
    for (std::size_t c = 0; c < 16; ++c) x[i + c] -= s * column[i + c];
}

// By columns, so that every number is summed in one order.
void substitute(const float* lower, const float* upper, const float* inverse, std::size_t size, float* x) {
  for (std::size_t j = 0; j < size; ++j) {
    x[j] *= inverse[j];
    subtract_column(x[j], lower + j * size, j / 16 * 16, size, x);
  }
  for (std::size_t j = size; j-- > 0;) {
    x[j] *= inverse[j];
    subtract_column(x[j], upper + j * size, 0, (j + 15) / 16 * 16, x);
  }
}

}  // namespace

const SpringKernels& spring_kernels() {
  static constexpr SpringKernels table{product,          product_double,  subtract_transposed,
                                       subtract_product, write_axial,     write_stiffness,
                                       add_blocks,       spread_scaled,   gather,
                                       diagonal,         diagonal_double, dot,
                                       square,           add_and_dot,     add,
                                       scale_add,        advance,         substitute};
  return table;
}

}  // namespace springnet::layers::KERNEL_NAMESPACE
