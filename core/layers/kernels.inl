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

// l = |dp|; n = dp / l, and 0 / 1 where l = 0.
struct Direction {
  double length, x, y, z;
};

[[gnu::always_inline]] inline Direction direction(double dx, double dy, double dz) {
  const double length = __builtin_sqrt(dx * dx + dy * dy + dz * dz);
  const double inverse = 1.0 / (length > 0.0 ? length : 1.0);
  return {length, dx * inverse, dy * inverse, dz * inverse};
}

enum class Reads { length, length_and_rate, relative_speed };

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
  if constexpr (reads != Reads::length) {
    dvx = n.vx[a] - n.vx[b];
    dvy = n.vy[a] - n.vy[b];
    dvz = n.vz[a] - n.vz[b];
  }
  element<reads>(dx, dy, dz, dvx, dvy, dvz, out, at);
}

template <Reads reads>
void gather(const SegmentSprings& springs, const NodeArrays& node_arrays, SegmentGeometry& out) {
  const NodeArrays nodes = node_arrays;
  if (springs.run_count > 0) {
    std::size_t at = 0;
    for (std::uint32_t r = 0; r < springs.run_count; ++r) {
      const std::size_t a = springs.runs[r].first;
      const std::size_t b = springs.runs[r].second;
      const std::size_t count = springs.runs[r].count;
      INDEPENDENT_ITERATIONS
      for (std::size_t i = 0; i < count; ++i) element<reads>(nodes, a + i, b + i, out, at + i);
      at += count;
    }
    return;
  }
  const std::uint32_t* RESTRICT first = springs.first;
  const std::uint32_t* RESTRICT second = springs.second;
  const std::size_t count = springs.count;
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

// One component of the forces of a run. Where its first and second ends overlap, they have a loop each, in which no
// node occurs twice.
template <bool has_2>
[[gnu::always_inline]] inline void scatter_run(const Run& run, const double* RESTRICT t1, const double* RESTRICT t2,
                                               const double* RESTRICT n, double* on_first, double* on_second,
                                               std::uint32_t origin) {
  const std::size_t count = run.count;
  double* RESTRICT first = on_first + run.first;
  double* RESTRICT second = on_second + (run.second - origin);
  if (run.second - run.first >= count) {
    INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) {
      const double force = (has_2 ? t1[i] + t2[i] : t1[i]) * n[i];
      first[i] -= force;
      second[i] += force;
    }
    return;
  }
  for (std::size_t i = 0; i < count; ++i) first[i] -= (has_2 ? t1[i] + t2[i] : t1[i]) * n[i];
  for (std::size_t i = 0; i < count; ++i) second[i] += (has_2 ? t1[i] + t2[i] : t1[i]) * n[i];
}
template <bool has_2>
[[gnu::always_inline]] inline void scatter_runs_of(const SegmentSprings& springs, const double* t1, const double* t2,
                                                   const Directions& n, const ForceArrays& first,
                                                   const ForceArrays& second, std::uint32_t origin) {
  std::size_t at = 0;
  for (std::uint32_t r = 0; r < springs.run_count; ++r) {
    const Run run = springs.runs[r];
    scatter_run<has_2>(run, t1 + at, t2 + (has_2 ? at : 0), n.x + at, first.x, second.x, origin);
    scatter_run<has_2>(run, t1 + at, t2 + (has_2 ? at : 0), n.y + at, first.y, second.y, origin);
    scatter_run<has_2>(run, t1 + at, t2 + (has_2 ? at : 0), n.z + at, first.z, second.z, origin);
    at += run.count;
  }
}
void scatter_runs(const SegmentSprings& springs, const double* value, const double* value_2, const Directions& n,
                  const ForceArrays& first, const ForceArrays& second, std::uint32_t origin) {
  if (value_2 == nullptr)
    scatter_runs_of<false>(springs, value, value_2, n, first, second, origin);
  else
    scatter_runs_of<true>(springs, value, value_2, n, first, second, origin);
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
                   const ForceArrays& force) {
  alignas(64) double of_spring[3][max_segment];
  forces_of(springs.count, value, value_2, n, of_spring);
  double *fx = force.x, *fy = force.y, *fz = force.z;
  for (std::size_t i = 0; i < springs.count; ++i) {
    const std::size_t a = springs.first[i];
    fx[a] -= of_spring[0][i];
    fy[a] -= of_spring[1][i];
    fz[a] -= of_spring[2][i];
  }
}

// ---- windows --------------------------------------------------------------------------------------------------------

// The compilers' vectors of four numbers mean the same for every instruction set.
using Four = double __attribute__((vector_size(32)));
[[gnu::always_inline]] inline void load(const double* from, Four& to) { __builtin_memcpy(&to, from, sizeof to); }
[[gnu::always_inline]] inline void store(const Four& from, double* to) { __builtin_memcpy(to, &from, sizeof from); }
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
  std::size_t i = 0;
  for (; i + 4 <= springs.count; i += 4) {
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
  for (; i < springs.count; ++i) {
    const double *const a = state[first[i] & mask], *const b = state[second[i] & mask];
    for (std::size_t c = 0; c < 3; ++c) {
      changes[c][i] = a[c] - b[c];
      changes[3 + c][i] = a[4 + c] - b[4 + c];
    }
  }
}

void scatter_window(const SegmentSprings& springs, const double* value, const double* value_2, const Directions& n,
                    const Window& window) {
  alignas(64) double of_spring[3][max_segment];
  forces_of(springs.count, value, value_2, n, of_spring);
  const std::uint32_t *const first = springs.first, *const second = springs.second, mask = window.mask;
  double(*const force)[4] = window.force;
  std::size_t i = 0;
  for (; i + 4 <= springs.count; i += 4) {
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
  for (; i < springs.count; ++i) {
    double *const on_first = force[first[i] & mask], *const on_second = force[second[i] & mask];
    for (std::size_t c = 0; c < 3; ++c) {
      on_first[c] -= of_spring[c][i];
      on_second[c] += of_spring[c][i];
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

}  // namespace

#include "layers/elements/kernels.inl"

const Kernels& kernels() {
  static constexpr Kernels table{gather<Reads::length>,
                                 gather<Reads::length_and_rate>,
                                 gather<Reads::relative_speed>,
                                 measure<Reads::length>,
                                 measure<Reads::length_and_rate>,
                                 measure<Reads::relative_speed>,
                                 scatter_runs,
                                 scatter_first,
                                 scatter_window,
                                 subtract_window,
                                 fill_window,
                                 drain_window,
                                 {geometry_of<Measure::angle>, geometry_of<Measure::dihedral>,
                                  geometry_of<Measure::area>, geometry_of<Measure::volume>, corner_forces}};
  return table;
}

}  // namespace springnet::layers::KERNEL_NAMESPACE
