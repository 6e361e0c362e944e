// Inner loops over the springs of a segment: lengths, rates and directions from the nodes' positions and velocities,
// and forces back to the nodes. Compiled once for each instruction set; all give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layers/elements/kernels.hpp"

namespace springnet::layers {

// Most springs of a segment: its scratch arrays fit the first-level cache.
inline constexpr std::size_t max_segment = 448;

// Springs (first + i, second + i), i < count: no indices are read, and both ends are loaded contiguously.
struct Run {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t count;
};

// Springs of one segment: first run_springs of them in runs, then the others, by their ends.
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

// Directions are zero where the ends coincide (or move alike), so that such a spring exerts no force.
struct alignas(64) SegmentGeometry {
  double length[max_segment];                                // l = |dp|, m
  double rate[max_segment];                                  // u = n.dv, m/s
  double nx[max_segment], ny[max_segment], nz[max_segment];  // n = dp / l
  double speed[max_segment];                                 // |dv|, m/s
  double sx[max_segment], sy[max_segment], sz[max_segment];  // dv / |dv|
};

// From the other end of each spring to this one, [component][spring]: m, m/s.
struct EndChanges {
  const double *x, *y, *z;
  const double *vx, *vy, *vz;
};

struct Kernels {
  void (*lengths)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  void (*lengths_and_rates)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  void (*relative_speeds)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  // The same of springs given by the differences of their ends.
  void (*lengths_of)(const EndChanges& changes, std::size_t count, SegmentGeometry& out);
  void (*lengths_and_rates_of)(const EndChanges& changes, std::size_t count, SegmentGeometry& out);
  void (*relative_speeds_of)(const EndChanges& changes, std::size_t count, SegmentGeometry& out);
  // Subtracts (axial + axial_2) n from the force on the first ends; adds it to the second ends if `to_second`. axial_2
  // may be null.
  void (*scatter_axial)(const SegmentSprings& springs, const SegmentGeometry& geometry, const double* axial,
                        const double* axial_2, bool to_second, const ForceArrays& force);
  // The same with value dv / |dv|.
  void (*scatter_relative)(const SegmentSprings& springs, const SegmentGeometry& geometry, const double* value,
                           bool to_second, const ForceArrays& force);
  ElementKernels elements;
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
