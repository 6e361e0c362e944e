// Included once for each instruction set with KERNEL_NAMESPACE defined. Plain loops only: the linker could pick an
// inline library function compiled here, for a wider instruction set, for the whole program.

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

// l = |dp|; n = dp / l, and 0 / 1 where l = 0.
struct Direction {
  double length, x, y, z;
};

[[gnu::always_inline]] inline Direction direction(double dx, double dy, double dz) {
  const double length = __builtin_sqrt(dx * dx + dy * dy + dz * dz);
  const double inverse = 1.0 / (length > 0.0 ? length : 1.0);
  return {length, dx * inverse, dy * inverse, dz * inverse};
}

enum class Reads { distance, length, length_and_rate, relative_speed };

// Geometry of spring `at` from the differences of its ends.
template <Reads reads>
[[gnu::always_inline]] inline void element(double dx, double dy, double dz, double dvx, double dvy, double dvz,
                                           SegmentGeometry& out, std::size_t at) {
  if constexpr (reads == Reads::relative_speed) {
    const Direction s = direction(dvx, dvy, dvz);
    out.speed[at] = s.length;
    out.sx[at] = s.x;
    out.sy[at] = s.y;
    out.sz[at] = s.z;
  } else if constexpr (reads == Reads::distance) {
    out.length[at] = __builtin_sqrt(dx * dx + dy * dy + dz * dz);
  } else {
    const Direction d = direction(dx, dy, dz);
    out.length[at] = d.length;
    out.nx[at] = d.x;
    out.ny[at] = d.y;
    out.nz[at] = d.z;
    if constexpr (reads == Reads::length_and_rate) out.rate[at] = d.x * dvx + d.y * dvy + d.z * dvz;
  }
}
// The same of a spring between nodes a and b.
template <Reads reads>
[[gnu::always_inline]] inline void element(const NodeArrays& n, std::size_t a, std::size_t b, SegmentGeometry& out,
                                           std::size_t at) {
  double dx = 0.0, dy = 0.0, dz = 0.0, dvx = 0.0, dvy = 0.0, dvz = 0.0;
  if constexpr (reads != Reads::relative_speed) {
    dx = n.px[a] - n.px[b];
    dy = n.py[a] - n.py[b];
    dz = n.pz[a] - n.pz[b];
  }
  if constexpr (reads == Reads::length_and_rate || reads == Reads::relative_speed) {
    dvx = n.vx[a] - n.vx[b];
    dvy = n.vy[a] - n.vy[b];
    dvz = n.vz[a] - n.vz[b];
  }
  element<reads>(dx, dy, dz, dvx, dvy, dvz, out, at);
}

template <Reads reads>
void gather(const SegmentSprings& springs, const NodeArrays& node_arrays, SegmentGeometry& out) {
  const NodeArrays nodes = node_arrays;
  const std::size_t count = springs.count;
  if (springs.chunks != nullptr) {
    const Chunk* chunk = springs.chunks;
    for (std::size_t at = 0; at < count; at += chunk_springs, ++chunk) {
      const std::size_t a = chunk->first, b = chunk->second;
      INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < chunk_springs; ++i) element<reads>(nodes, a + i, b + i, out, at + i);
    }
    return;
  }
  const std::uint32_t* RESTRICT first = springs.first;
  const std::uint32_t* RESTRICT second = springs.second;
  INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < count; ++i) element<reads>(nodes, first[i], second[i], out, i);
}

template <Reads reads>
void measure(const EndChanges& changes, std::size_t count, SegmentGeometry& out) {
  const EndChanges c = changes;
  INDEPENDENT_ITERATIONS
  for (std::size_t i = 0; i < count; ++i) {
    if constexpr (reads == Reads::length)
      element<reads>(c.x[i], c.y[i], c.z[i], 0.0, 0.0, 0.0, out, i);
    else if constexpr (reads == Reads::length_and_rate)
      element<reads>(c.x[i], c.y[i], c.z[i], c.vx[i], c.vy[i], c.vz[i], out, i);
    else
      element<reads>(0.0, 0.0, 0.0, c.vx[i], c.vy[i], c.vz[i], out, i);
  }
}

void settle_dead(const std::uint8_t* live, std::size_t count, std::size_t living, SegmentGeometry& g) {
  const double length = g.length[living], rate = g.rate[living], speed = g.speed[living];
  for (std::size_t at = 0; at < count; at += chunk_springs) {
    const std::uint64_t mask = live[at / chunk_springs];
    if (mask == 0xff) continue;
    for (std::size_t i = 0; i < chunk_springs; ++i) {
      const bool has_spring = ((mask >> i) & 1u) != 0;
      g.length[at + i] = has_spring ? g.length[at + i] : length;
      g.rate[at + i] = has_spring ? g.rate[at + i] : rate;
      g.speed[at + i] = has_spring ? g.speed[at + i] : speed;
      g.nx[at + i] = has_spring ? g.nx[at + i] : 0.0;
      g.ny[at + i] = has_spring ? g.ny[at + i] : 0.0;
      g.nz[at + i] = has_spring ? g.nz[at + i] : 0.0;
      g.sx[at + i] = has_spring ? g.sx[at + i] : 0.0;
      g.sy[at + i] = has_spring ? g.sy[at + i] : 0.0;
      g.sz[at + i] = has_spring ? g.sz[at + i] : 0.0;
    }
  }
}

// The forces on the nodes of a chunk.
struct ChunkForces {
  Eight x, y, z;
};
[[gnu::always_inline]] inline void load(const ForceArrays& force, std::ptrdiff_t at, ChunkForces& to) {
  load(force.x + at, to.x);
  load(force.y + at, to.y);
  load(force.z + at, to.z);
}
[[gnu::always_inline]] inline void store(const ChunkForces& from, const ForceArrays& force, std::ptrdiff_t at) {
  store(from.x, force.x + at);
  store(from.y, force.y + at);
  store(from.z, force.z + at);
}

// Those on the first ends stay in registers as long as chunks have the same ones.
template <bool has_2>
[[gnu::always_inline]] inline void scatter_chunks_of(const SegmentSprings& springs, const double* t1, const double* t2,
                                                     const Directions& n, const ForceArrays& arrays,
                                                     std::uint32_t origin) {
  if (springs.count == 0) return;
  const ForceArrays force = arrays;
  const double *nx = n.x, *ny = n.y, *nz = n.z;
  const Chunk* chunk = springs.chunks;
  const std::size_t count = springs.count;
  // A chunk at the end of a net may begin before the first node.
  std::ptrdiff_t first = std::ptrdiff_t{chunk->first} - origin;
  ChunkForces own;
  load(force, first, own);
  for (std::size_t at = 0; at < count; at += chunk_springs, ++chunk) {
    const std::ptrdiff_t a = std::ptrdiff_t{chunk->first} - origin, b = std::ptrdiff_t{chunk->second} - origin;
    if (a != first) {
      store(own, force, first);
      first = a;
      load(force, first, own);
    }
    Eight value, x, y, z;
    load(t1 + at, value);
    if constexpr (has_2) {
      Eight other;
      load(t2 + at, other);
      value += other;
    }
    load(nx + at, x);
    load(ny + at, y);
    load(nz + at, z);
    x *= value;
    y *= value;
    z *= value;
    own.x -= x;
    own.y -= y;
    own.z -= z;
    const bool overlaps = b - a < std::ptrdiff_t{chunk_springs};
    if (overlaps) store(own, force, first);
    ChunkForces other_ends;
    load(force, b, other_ends);
    other_ends.x += x;
    other_ends.y += y;
    other_ends.z += z;
    store(other_ends, force, b);
    if (overlaps) load(force, first, own);
  }
  store(own, force, first);
}
void scatter_chunks(const SegmentSprings& springs, const double* value, const double* value_2, const Directions& n,
                    const ForceArrays& force, std::uint32_t origin) {
  if (value_2 == nullptr)
    scatter_chunks_of<false>(springs, value, value_2, n, force, origin);
  else
    scatter_chunks_of<true>(springs, value, value_2, n, force, origin);
}

// Forces of springs, [component][spring].
[[gnu::always_inline]] inline void forces_of(std::size_t count, const double* RESTRICT value,
                                             const double* RESTRICT value_2, const Directions& n,
                                             double (*RESTRICT force)[max_segment]) {
  const double *RESTRICT x = n.x, *RESTRICT y = n.y, *RESTRICT z = n.z;
  for (std::size_t i = 0; i < count; ++i) {
    const double sum = value_2 == nullptr ? value[i] : value[i] + value_2[i];
    force[0][i] = sum * x[i];
    force[1][i] = sum * y[i];
    force[2][i] = sum * z[i];
  }
}

void scatter_first(const SegmentSprings& springs, const double* value, const double* value_2, const Directions& n,
                   const ForceArrays& force, std::uint32_t origin) {
  alignas(64) double of_spring[3][max_segment];
  forces_of(springs.count, value, value_2, n, of_spring);
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
  forces_of(springs.count, value, value_2, n, of_spring);
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

const Kernels& kernels() {
  static constexpr Kernels table{gather<Reads::length>,
                                 gather<Reads::length_and_rate>,
                                 gather<Reads::relative_speed>,
                                 gather<Reads::distance>,
                                 measure<Reads::length>,
                                 measure<Reads::length_and_rate>,
                                 measure<Reads::relative_speed>,
                                 settle_dead,
                                 scatter_chunks,
                                 scatter_first,
                                 scatter_window,
                                 subtract_window,
                                 fill_window,
                                 drain_window,
                                 weigh,
                                 all_finite,
                                 {geometry_of<Measure::angle>, geometry_of<Measure::dihedral>,
                                  geometry_of<Measure::area>, geometry_of<Measure::volume>, corner_forces}};
  return table;
}

}  // namespace springnet::layers::KERNEL_NAMESPACE
