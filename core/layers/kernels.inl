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
  std::size_t at = 0;
  for (std::uint32_t r = 0; r < springs.run_count; ++r) {
    const std::size_t a = springs.runs[r].first;
    const std::size_t b = springs.runs[r].second;
    const std::size_t count = springs.runs[r].count;
    INDEPENDENT_ITERATIONS
    for (std::size_t i = 0; i < count; ++i) element<reads>(nodes, a + i, b + i, out, at + i);
    at += count;
  }
  const std::uint32_t* RESTRICT first = springs.first;
  const std::uint32_t* RESTRICT second = springs.second;
  const std::size_t count = springs.count;
  INDEPENDENT_ITERATIONS
  for (std::size_t i = at; i < count; ++i) element<reads>(nodes, first[i], second[i], out, i);
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

// One component of the forces of a run. First and second ends have a loop each, in which no node occurs twice.
[[gnu::always_inline]] inline void scatter_run(const Run& run, const double* RESTRICT tension, const double* RESTRICT n,
                                               bool to_second, double* force) {
  const std::size_t count = run.count;
  double* RESTRICT first = force + run.first;
  for (std::size_t i = 0; i < count; ++i) first[i] -= tension[i] * n[i];
  if (!to_second) return;
  double* RESTRICT second = force + run.second;
  for (std::size_t i = 0; i < count; ++i) second[i] += tension[i] * n[i];
}

void scatter(const SegmentSprings& springs, const double* RESTRICT tension, const double* RESTRICT nx,
             const double* RESTRICT ny, const double* RESTRICT nz, bool to_second, const ForceArrays& force) {
  std::size_t at = 0;
  for (std::uint32_t r = 0; r < springs.run_count; ++r) {
    const Run& run = springs.runs[r];
    scatter_run(run, tension + at, nx + at, to_second, force.x);
    scatter_run(run, tension + at, ny + at, to_second, force.y);
    scatter_run(run, tension + at, nz + at, to_second, force.z);
    at += run.count;
  }
  double *fx = force.x, *fy = force.y, *fz = force.z;
  for (std::size_t i = at; i < springs.count; ++i) {
    const std::size_t a = springs.first[i];
    const double x = tension[i] * nx[i], y = tension[i] * ny[i], z = tension[i] * nz[i];
    fx[a] -= x;
    fy[a] -= y;
    fz[a] -= z;
    if (to_second) {
      const std::size_t b = springs.second[i];
      fx[b] += x;
      fy[b] += y;
      fz[b] += z;
    }
  }
}

void scatter_axial(const SegmentSprings& springs, const SegmentGeometry& g, const double* axial, const double* axial_2,
                   bool to_second, const ForceArrays& force) {
  if (axial_2 == nullptr) {
    scatter(springs, axial, g.nx, g.ny, g.nz, to_second, force);
    return;
  }
  alignas(64) double sum[max_segment];
  const double* RESTRICT t1 = axial;
  const double* RESTRICT t2 = axial_2;
  for (std::size_t i = 0; i < springs.count; ++i) sum[i] = t1[i] + t2[i];
  scatter(springs, sum, g.nx, g.ny, g.nz, to_second, force);
}

void scatter_relative(const SegmentSprings& springs, const SegmentGeometry& g, const double* value, bool to_second,
                      const ForceArrays& force) {
  scatter(springs, value, g.sx, g.sy, g.sz, to_second, force);
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
                                 scatter_axial,
                                 scatter_relative,
                                 {geometry_of<Measure::angle>, geometry_of<Measure::dihedral>,
                                  geometry_of<Measure::area>, geometry_of<Measure::volume>, corner_forces}};
  return table;
}

}  // namespace springnet::layers::KERNEL_NAMESPACE
