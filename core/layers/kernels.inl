// Included once for each instruction set with KERNEL_NAMESPACE defined. Plain loops only: the linker could pick an
// inline library function compiled here, for a wider instruction set, for the whole program. (Intrinsics are never
// functions of their own.)

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include "layers/elements/gradients.hpp"
#include "layers/kernels.hpp"

#define RESTRICT __restrict
// Asserts that no iteration of the following loop reads what another one writes.
#if defined(__clang__)
#define INDEPENDENT_ITERATIONS _Pragma("clang loop vectorize(assume_safety)")
#else
#define INDEPENDENT_ITERATIONS _Pragma("GCC ivdep")
#endif

namespace springnet::layers::KERNEL_NAMESPACE {
namespace {

// The compilers' vectors of four and eight numbers mean the same for every instruction set.
using Four = double __attribute__((vector_size(32)));
using Eight = double __attribute__((vector_size(64)));
static_assert(sizeof(Eight) == chunk_springs * sizeof(double));
template <class Vector>
[[gnu::always_inline]] inline void load(const double* from, Vector& to) {
  __builtin_memcpy(&to, from, sizeof to);
}
template <class Vector>
[[gnu::always_inline]] inline void store(const Vector& from, double* to) {
  __builtin_memcpy(to, &from, sizeof from);
}

[[gnu::always_inline]] inline void load(const double* from, double& to) { to = *from; }
[[gnu::always_inline]] inline void store(const double& from, double* to) { *to = from; }

[[gnu::always_inline]] inline double root(double value) { return __builtin_sqrt(value); }
[[gnu::always_inline]] inline Eight root(const Eight& value) {
#if defined(__AVX512F__)
  return reinterpret_cast<Eight>(_mm512_maskz_sqrt_pd(0xff, reinterpret_cast<__m512d>(value)));
#elif defined(__AVX__)
  const Four low = __builtin_shufflevector(value, value, 0, 1, 2, 3);
  const Four high = __builtin_shufflevector(value, value, 4, 5, 6, 7);
  const auto of_low = reinterpret_cast<Four>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(low)));
  const auto of_high = reinterpret_cast<Four>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(high)));
  return __builtin_shufflevector(of_low, of_high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  Eight roots = value;
  for (std::size_t i = 0; i < chunk_springs; ++i) roots[i] = __builtin_sqrt(value[i]);
  return roots;
#endif
}
// 0 becomes 1.
[[gnu::always_inline]] inline double or_one(double length) { return length > 0.0 ? length : 1.0; }
[[gnu::always_inline]] inline Eight or_one(const Eight& length) { return length > 0.0 ? length : 1.0 - Eight{}; }

using EightIntegers = std::int64_t __attribute__((vector_size(64)));
// Of one spring, or of eight: l = |d|; n = d / l, and 0 / 1 where l = 0.
template <class Value>
struct Direction {
  Value length, x, y, z;
};
template <class Value>
[[gnu::always_inline]] inline Direction<Value> direction(const Value& dx, const Value& dy, const Value& dz) {
  const Value length = root(dx * dx + dy * dy + dz * dz);
  const Value inverse = 1.0 / or_one(length);
  return {length, dx * inverse, dy * inverse, dz * inverse};
}

// Differences of the ends: positions, velocities.
template <class Value>
struct Differences {
  Value p[3], v[3];
};

enum class Reads { distance, length, length_and_rate, relative_speed };
constexpr bool reads_positions(Reads reads) { return reads != Reads::relative_speed; }
constexpr bool reads_velocities(Reads reads) {
  return reads == Reads::length_and_rate || reads == Reads::relative_speed;
}

// Geometry of springs from `at` on.
template <Reads reads, class Value>
[[gnu::always_inline]] inline void element(const Differences<Value>& d, SegmentGeometry& out, std::size_t at) {
  if constexpr (reads == Reads::relative_speed) {
    const Direction<Value> s = direction(d.v[0], d.v[1], d.v[2]);
    store(s.length, out.speed + at);
    store(s.x, out.sx + at);
    store(s.y, out.sy + at);
    store(s.z, out.sz + at);
  } else if constexpr (reads == Reads::distance) {
    store(root(d.p[0] * d.p[0] + d.p[1] * d.p[1] + d.p[2] * d.p[2]), out.length + at);
  } else {
    const Direction<Value> n = direction(d.p[0], d.p[1], d.p[2]);
    store(n.length, out.length + at);
    store(n.x, out.nx + at);
    store(n.y, out.ny + at);
    store(n.z, out.nz + at);
    if constexpr (reads == Reads::length_and_rate)
      store(Value(n.x * d.v[0] + n.y * d.v[1] + n.z * d.v[2]), out.rate + at);
  }
}
// subtract(values, difference) of those that are read.
template <Reads reads, class Subtract, class Value>
[[gnu::always_inline]] inline void subtract_ends(const NodeArrays& n, const Subtract& subtract, Differences<Value>& d) {
  if constexpr (reads_positions(reads)) {
    subtract(n.px, d.p[0]);
    subtract(n.py, d.p[1]);
    subtract(n.pz, d.p[2]);
  }
  if constexpr (reads_velocities(reads)) {
    subtract(n.vx, d.v[0]);
    subtract(n.vy, d.v[1]);
    subtract(n.vz, d.v[2]);
  }
}
template <Reads reads, class Value>
[[gnu::always_inline]] inline void element(const NodeArrays& n, std::size_t a, std::size_t b, SegmentGeometry& out,
                                           std::size_t at) {
  Differences<Value> d;
  const auto subtract = [&](const double* values, Value& difference) {
    Value first, second;
    load(values + a, first);
    load(values + b, second);
    difference = first - second;
  };
  subtract_ends<reads>(n, subtract, d);
  element<reads>(d, out, at);
}

[[gnu::always_inline]] inline EightIntegers flags_of(std::int64_t mask) {
  const EightIntegers bits = {1, 2, 4, 8, 16, 32, 64, 128};
  return (mask & bits) != 0;
}
// Slots without a spring have the ends of the first one with a spring.
template <Reads reads>
[[gnu::always_inline]] inline void gather_partial_chunk(const Chunk& chunk, unsigned mask, const NodeArrays& nodes,
                                                        SegmentGeometry& out, std::size_t at) {
  const std::size_t a = chunk.first, b = chunk.second;
  const auto one = static_cast<std::size_t>(__builtin_ctz(mask));
  const EightIntegers live = flags_of(mask);
  Differences<Eight> d;
  const auto subtract = [&](const double* values, Eight& difference) {
    Eight first, second;
    load(values + a, first);
    load(values + b, second);
    difference = live ? first - second : (values[a + one] - values[b + one]) - Eight{};
  };
  subtract_ends<reads>(nodes, subtract, d);
  element<reads>(d, out, at);
}

[[gnu::always_inline]] inline unsigned live_of(const SegmentSprings& springs, std::size_t at) {
  return springs.live == nullptr ? 0xffu : springs.live[at / chunk_springs];
}
template <Reads reads>
[[gnu::always_inline]] inline void gather_chunk(const SegmentSprings& springs, const NodeArrays& nodes,
                                                SegmentGeometry& out, std::size_t at) {
  const Chunk& chunk = springs.chunks[at / chunk_springs];
  const unsigned live = live_of(springs, at);
  if (live == 0xff || live == 0)
    element<reads, Eight>(nodes, chunk.first, chunk.second, out, at);
  else
    gather_partial_chunk<reads>(chunk, live, nodes, out, at);
}

template <Reads reads>
void gather(const SegmentSprings& springs, const NodeArrays& node_arrays, SegmentGeometry& out) {
  const NodeArrays nodes = node_arrays;
  const std::size_t count = springs.count;
  if (springs.chunks != nullptr) {
    for (std::size_t at = 0; at < count; at += chunk_springs) gather_chunk<reads>(springs, nodes, out, at);
    return;
  }
  const std::uint32_t* RESTRICT first = springs.first;
  const std::uint32_t* RESTRICT second = springs.second;
  INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < count; ++i) element<reads, double>(nodes, first[i], second[i], out, i);
}

template <Reads reads>
void measure(const EndChanges& changes, std::size_t count, SegmentGeometry& out) {
  const EndChanges c = changes;
  INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < count; ++i) {
    Differences<double> d;
    if constexpr (reads_positions(reads)) {
      d.p[0] = c.x[i];
      d.p[1] = c.y[i];
      d.p[2] = c.z[i];
    }
    if constexpr (reads_velocities(reads)) {
      d.v[0] = c.vx[i];
      d.v[1] = c.vy[i];
      d.v[2] = c.vz[i];
    }
    element<reads>(d, out, i);
  }
}

[[gnu::always_inline]] inline void choose(const EightIntegers& live, double* values, double otherwise) {
  Eight own;
  load(values, own);
  store(live ? own : otherwise - Eight{}, values);
}
// Whether slots of eight have values of another spring to take.
[[gnu::always_inline]] inline bool is_unsettled(unsigned live, bool in_chunks) {
  return in_chunks ? live == 0 : live != 0xff;
}
void settle_dead(const SegmentSprings& springs, std::size_t living, SegmentGeometry& g) {
  const double length = g.length[living], rate = g.rate[living];
  for (std::size_t at = 0; at < springs.count; at += chunk_springs) {
    const unsigned live = springs.live[at / chunk_springs];
    if (!is_unsettled(live, springs.chunks != nullptr)) continue;
    choose(flags_of(live), g.length + at, length);
    choose(flags_of(live), g.rate + at, rate);
  }
}
void settle_dead_speeds(const SegmentSprings& springs, std::size_t living, SegmentGeometry& g) {
  for (std::size_t at = 0; at < springs.count; at += chunk_springs) {
    const unsigned live = springs.live[at / chunk_springs];
    if (is_unsettled(live, springs.chunks != nullptr)) choose(flags_of(live), g.speed + at, g.speed[living]);
  }
}

// Forces of the chunk whose slots begin at `at`.
template <bool has_two>
[[gnu::always_inline]] inline void forces_of_chunk(const ChunkForces& forces, std::size_t at) {
  const double *const values = forces.value + at, *const n = forces.n + at;
  Eight value, x, y, z;
  load(values, value);
  if constexpr (has_two) {
    Eight other;
    load(values + max_segment, other);
    value += other;
  }
  load(n, x);
  load(n + max_segment, y);
  load(n + 2 * max_segment, z);
  const Chunk& chunk = forces.springs.chunks[at / chunk_springs];
  double* const force = forces.force.x + chunk.place;
  const std::size_t row = forces.force.row;
  x *= value;
  y *= value;
  z *= value;
  const unsigned live = live_of(forces.springs, at);
  if (live != 0xff) {
    const EightIntegers flags = flags_of(live);
    x = flags ? x : Eight{};
    y = flags ? y : Eight{};
    z = flags ? z : Eight{};
  }
  store(x, force);
  store(y, force + row);
  store(z, force + 2 * row);
  if (!chunk.is_last) return;
  for (std::size_t c = 0; c < 3; ++c) store(Eight{}, force + c * row + chunk_springs);
}
[[gnu::always_inline]] inline void add_to(double* values, const Eight& other) {
  Eight sum;
  load(values, sum);
  store(sum + other, values);
}
void add_chunk_forces(const ChunkForces& forces) {
  for (std::size_t at = 0; at < forces.springs.count; at += chunk_springs) {
    Eight value, n;
    load(forces.value + at, value);
    const std::size_t place = forces.springs.chunks[at / chunk_springs].place;
    const EightIntegers flags = flags_of(live_of(forces.springs, at));
    for (std::size_t c = 0; c < 3; ++c) {
      load(forces.n + c * max_segment + at, n);
      add_to(forces.force.component(c) + place, flags ? n * value : Eight{});
    }
  }
}

template <bool has_two>
[[gnu::always_inline]] inline void forces_from(const ChunkForces& forces, std::size_t begin) {
  for (std::size_t at = begin; at < forces.springs.count; at += chunk_springs) forces_of_chunk<has_two>(forces, at);
}
void chunk_forces(const ChunkForces& given) {
  const ChunkForces forces = given;
  if (forces.adds)
    add_chunk_forces(forces);
  else if (forces.has_two)
    forces_from<true>(forces, 0);
  else
    forces_from<false>(forces, 0);
}

template <Reads reads, bool has_two>
[[gnu::always_inline]] inline void forces_and_gather_of(const ChunkForces& forces, const SegmentSprings& springs,
                                                        const NodeArrays& nodes, SegmentGeometry& out) {
  const std::size_t both = springs.count < forces.springs.count ? springs.count : forces.springs.count;
  std::size_t at = 0;
  for (; at < both; at += chunk_springs) {
    gather_chunk<reads>(springs, nodes, out, at);
    forces_of_chunk<has_two>(forces, at);
  }
  forces_from<has_two>(forces, at);
  for (; at < springs.count; at += chunk_springs) gather_chunk<reads>(springs, nodes, out, at);
}
template <Reads reads>
void forces_and_gather(const ChunkForces& given_forces, const SegmentSprings& given_springs,
                       const NodeArrays& node_arrays, SegmentGeometry& out) {
  const ChunkForces forces = given_forces;
  const SegmentSprings springs = given_springs;
  const NodeArrays nodes = node_arrays;
  if (forces.adds) {
    add_chunk_forces(forces);
    gather<reads>(springs, nodes, out);
  } else if (forces.has_two) {
    forces_and_gather_of<reads, true>(forces, springs, nodes, out);
  } else {
    forces_and_gather_of<reads, false>(forces, springs, nodes, out);
  }
}

void sum_chunk_forces(const NodeSum* sums, std::size_t count, const std::uint32_t* places, const ForceRows& of_chunks,
                      const ForceArrays& force) {
  const double* const of_x = of_chunks.x;
  const double *const of_y = of_x + of_chunks.row, *const of_z = of_y + of_chunks.row;
  const ForceArrays on = force;
  for (std::size_t k = 0; k < count; ++k) {
    const NodeSum sum = sums[k];
    Eight x, y, z, other;
    load(on.x + sum.node, x);
    load(on.y + sum.node, y);
    load(on.z + sum.node, z);
    for (const std::uint32_t* const end = places + sum.first_ends; places != end; ++places) {
      load(of_x + *places, other);
      x -= other;
      load(of_y + *places, other);
      y -= other;
      load(of_z + *places, other);
      z -= other;
    }
    for (const std::uint32_t* const end = places + sum.second_ends; places != end; ++places) {
      load(of_x + *places, other);
      x += other;
      load(of_y + *places, other);
      y += other;
      load(of_z + *places, other);
      z += other;
    }
    store(x, on.x + sum.node);
    store(y, on.y + sum.node);
    store(z, on.z + sum.node);
  }
}

// Forces of springs, [component][spring].
[[gnu::always_inline]] inline void forces_of(const SegmentSprings& springs, const double* RESTRICT value,
                                             const double* RESTRICT value_2, const Directions& n,
                                             double (*RESTRICT force)[max_segment]) {
  const std::size_t count = springs.count;
  const double *RESTRICT x = n.x, *RESTRICT y = n.y, *RESTRICT z = n.z;
  for (std::size_t i = 0; i < count; ++i) {
    const double sum = value_2 == nullptr ? value[i] : value[i] + value_2[i];
    force[0][i] = sum * x[i];
    force[1][i] = sum * y[i];
    force[2][i] = sum * z[i];
  }
  if (springs.live == nullptr) return;
  for (std::size_t at = 0; at < count; at += chunk_springs) {
    const EightIntegers flags = flags_of(springs.live[at / chunk_springs]);
    for (std::size_t c = 0; c < 3; ++c) choose(flags, force[c] + at, 0.0);
  }
}

void scatter_first(const SegmentSprings& springs, const double* value, const double* value_2, const Directions& n,
                   const ForceArrays& force, std::uint32_t origin) {
  alignas(64) double of_spring[3][max_segment];
  forces_of(springs, value, value_2, n, of_spring);
  double *fx = force.x, *fy = force.y, *fz = force.z;
  for (std::size_t i = 0; i < springs.count; ++i) {
    const std::size_t a = springs.first[i] - origin;
    fx[a] -= of_spring[0][i];
    fy[a] -= of_spring[1][i];
    fz[a] -= of_spring[2][i];
  }
}

// ---- windows --------------------------------------------------------------------------------------------------------

// Rows become columns.
[[gnu::always_inline]] inline void transpose(Four& a, Four& b, Four& c, Four& d) {
  const Four ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Four cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5);
  c = __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7);
  d = __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7);
}

void subtract_window(const SegmentSprings& springs, const Window& window, double (*changes)[max_segment]) {
  const std::uint32_t *const first = springs.first, *const second = springs.second, mask = window.mask;
  const double(*const state)[8] = window.state;
  for (std::size_t i = 0; i < springs.count; i += 4) {
    for (std::size_t half = 0; half < 2; ++half) {
      Four d[4];
      for (std::size_t j = 0; j < 4; ++j) {
        Four a, b;
        load(state[first[i + j] & mask] + 4 * half, a);
        load(state[second[i + j] & mask] + 4 * half, b);
        d[j] = a - b;
      }
      transpose(d[0], d[1], d[2], d[3]);
      for (std::size_t c = 0; c < 3; ++c) store(d[c], changes[3 * half + c] + i);
    }
  }
}

void scatter_window(const SegmentSprings& springs, const double* value, const double* value_2, const Directions& n,
                    const Window& window) {
  alignas(64) double of_spring[3][max_segment];
  forces_of(springs, value, value_2, n, of_spring);
  const std::uint32_t *const first = springs.first, *const second = springs.second, mask = window.mask;
  double(*const force)[4] = window.force;
  for (std::size_t i = 0; i < springs.count; i += 4) {
    Four f[4];
    for (std::size_t c = 0; c < 3; ++c) load(of_spring[c] + i, f[c]);
    f[3] = Four{};
    transpose(f[0], f[1], f[2], f[3]);
    for (std::size_t j = 0; j < 4; ++j) {
      double *const on_first = force[first[i + j] & mask], *const on_second = force[second[i + j] & mask];
      Four sum;
      load(on_first, sum);
      store(sum - f[j], on_first);
      load(on_second, sum);
      store(sum + f[j], on_second);
    }
  }
}

void fill_window(const NodeArrays& nodes, std::uint32_t begin, std::uint32_t end, const Window& window) {
  const NodeArrays n = nodes;
  for (std::uint32_t k = begin; k < end; ++k) {
    double* RESTRICT const state = window.state[k & window.mask];
    state[0] = n.px[k];
    state[1] = n.py[k];
    state[2] = n.pz[k];
    state[3] = 0.0;
    state[4] = n.vx[k];
    state[5] = n.vy[k];
    state[6] = n.vz[k];
    state[7] = 0.0;
    double* RESTRICT const force = window.force[k & window.mask];
    for (std::size_t c = 0; c < 4; ++c) force[c] = 0.0;
  }
}

void drain_window(const Window& window, std::uint32_t begin, std::uint32_t end, const ForceArrays& force,
                  std::uint32_t origin) {
  double *const x = force.x, *const y = force.y, *const z = force.z;
  for (std::uint32_t k = begin; k < end; ++k) {
    const double* const own = window.force[k & window.mask];
    x[k - origin] += own[0];
    y[k - origin] += own[1];
    z[k - origin] += own[2];
  }
}

void weigh(std::size_t count, const double* RESTRICT mass, const double gravity[3], const double* const load[3],
           double* const force[3]) {
  for (std::size_t c = 0; c < 3; ++c) {
    const double g = gravity[c];
    const double* RESTRICT of_load = load[c];
    double* RESTRICT out = force[c];
    if (of_load == nullptr) {
      for (std::size_t i = 0; i < count; ++i) out[i] = mass[i] * g;
    } else {
      for (std::size_t i = 0; i < count; ++i) out[i] = mass[i] * g + of_load[i];
    }
  }
}

bool all_positive(const double* values, std::size_t count) {
  EightIntegers positive = flags_of(0xff);
  for (std::size_t at = 0; at < count; at += chunk_springs) {
    Eight eight;
    load(values + at, eight);
    positive &= eight > 0.0;
  }
  std::int64_t all = -1;
  for (std::size_t i = 0; i < chunk_springs; ++i) all &= positive[i];
  return all != 0;
}

// In integers, so that the loop vectorises: adding 1 to an exponent of all ones overflows into the sign bit.
[[gnu::always_inline]] inline std::uint64_t top_bits(const double* RESTRICT values, std::size_t count) {
  constexpr std::uint64_t magnitude = ~std::uint64_t{0} >> 1, one = std::uint64_t{1} << 52;
  std::uint64_t top = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint64_t bits;
    __builtin_memcpy(&bits, values + i, sizeof bits);
    top |= (bits & magnitude) + one;
  }
  return top;
}
bool all_finite(const double* x, const double* y, const double* z, std::size_t count) {
  return ((top_bits(x, count) | top_bits(y, count) | top_bits(z, count)) >> 63) == 0;
}

}  // namespace

#include "layers/elements/kernels.inl"
#include "layers/elements/several_kernels.inl"

const Kernels& kernels() {
  static constexpr Kernels table{gather<Reads::length>,
                                 gather<Reads::length_and_rate>,
                                 gather<Reads::relative_speed>,
                                 gather<Reads::distance>,
                                 measure<Reads::length>,
                                 measure<Reads::length_and_rate>,
                                 measure<Reads::relative_speed>,
                                 settle_dead,
                                 settle_dead_speeds,
                                 chunk_forces,
                                 forces_and_gather<Reads::length>,
                                 forces_and_gather<Reads::length_and_rate>,
                                 sum_chunk_forces,
                                 scatter_first,
                                 scatter_window,
                                 subtract_window,
                                 fill_window,
                                 drain_window,
                                 weigh,
                                 all_positive,
                                 all_finite,
                                 {geometry_of<Measure::angle>, geometry_of<Measure::dihedral>,
                                  geometry_of<Measure::area>, geometry_of<Measure::volume>, corner_forces},
                                 {several_geometry, several_forces, several_sum, several_blocks, several_spread}};
  return table;
}

}  // namespace springnet::layers::KERNEL_NAMESPACE
