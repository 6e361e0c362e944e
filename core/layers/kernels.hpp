// The inner loops over springs of one segment of a tile: from node arrays to lengths, rates and directions, and from
// tensions back to nodes. Built once for each instruction set, all with the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

namespace springnet::layers {

// A segment has at most this many springs, so that its scratch arrays stay in the first-level cache.
inline constexpr std::size_t max_segment = 448;

// Springs (first + i, second + i), i < count: no indices to read, both ends load contiguously.
struct Run {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t count;
};

// Springs of one segment: those of the runs, then pairs[run_springs …].
struct SegmentSprings {
  const Run* runs;
  std::uint32_t run_count;
  std::uint32_t run_springs;
  std::uint32_t count;
  const std::uint32_t* first;   // [count]
  const std::uint32_t* second;  // [count]
};

struct NodeArrays {
  const double *px, *py, *pz;  // m
  const double *vx, *vy, *vz;  // m/s
};

struct ForceArrays {
  double *x, *y, *z;  // N
};

// Directions are zero where the ends coincide, so that no law can push such a spring.
struct alignas(64) SegmentGeometry {
  double length[max_segment];                                // l = |dp|, m
  double rate[max_segment];                                  // u = n.dv, m/s
  double nx[max_segment], ny[max_segment], nz[max_segment];  // n = dp / l
  double speed[max_segment];                                 // |dv|, m/s
  double sx[max_segment], sy[max_segment], sz[max_segment];  // dv / |dv|
};

struct Kernels {
  void (*lengths)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  void (*lengths_and_rates)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  void (*relative_speeds)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  // force on first ends -= (axial + axial_2) n, second ends += the same. axial_2 may be null.
  void (*scatter_axial)(const SegmentSprings& springs, const SegmentGeometry& geometry, const double* axial,
                        const double* axial_2, bool to_second, const ForceArrays& force);
  // The same along dv / |dv|.
  void (*scatter_relative)(const SegmentSprings& springs, const SegmentGeometry& geometry, const double* value,
                           bool to_second, const ForceArrays& force);
};

namespace generic {
const Kernels& kernels();
}
namespace avx2 {
const Kernels& kernels();
}
namespace avx512 {
const Kernels& kernels();
}

}  // namespace springnet::layers
