// Inner loops over the springs of a segment: lengths, rates and directions from the nodes' positions and velocities,
// and forces back to the nodes. Compiled once for each instruction set; all give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layers/elements/kernels.hpp"
#include "layers/elements/several_kernels.hpp"

namespace springnet::layers {

// Most slots of a segment: its scratch arrays fit the first-level cache.
inline constexpr std::size_t max_segment = 448;
inline constexpr std::uint32_t no_spring = 0xffffffffu;  // in a place of a segment
// Springs of a chunk, as many as the widest vectors have numbers.
inline constexpr std::uint32_t chunk_springs = 8;
static_assert(chunk_springs == several_at_once);

// Springs (first + i, second + i), i < chunk_springs: no indices are read, and both ends are loaded contiguously.
struct Chunk {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t place;  // of their forces among those of the tile
  bool is_last;         // of consecutive chunks of equal distance; eight zeros follow their forces
};

// Slots for springs: in chunks, or, without chunks, by their ends. `count` is a multiple of chunk_springs.
struct SegmentSprings {
  const Chunk* chunks;
  const std::uint8_t* live;  // [slot / 8] a bit for each slot with a spring; null: all have one
  std::uint32_t count;
  const std::uint32_t* first;   // [count]
  const std::uint32_t* second;  // [count]
};

// Forces of a tile's chunks on eight nodes that follow each other: `first_ends` places of forces to subtract, then
// `second_ends` places of forces to add.
struct NodeSum {
  std::uint32_t node;  // in arrays that begin with the unit
  std::uint32_t first_ends, second_ends;
};

struct InternalView;

// What springs and elements read.
struct NodeArrays {
  const double *px, *py, *pz;              // m
  const double *vx, *vy, *vz;              // m/s
  const InternalView* internal = nullptr;  // states of laws; null: those at the start of a run, as laws declare them
};

struct ForceArrays {
  double *x, *y, *z;  // N
};

// Nodes in the places (number modulo the number of places) of a window that moves along with the tiles: all values of
// a node next to each other, for springs that are read and written through indices.
struct Window {
  double (*state)[8];  // px, py, pz, 0 and vx, vy, vz, 0
  double (*force)[4];  // x, y, z, 0, N
  std::uint32_t mask;  // of a node's number: the places are a power of 2
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

// Along which forces act.
struct Directions {
  const double *x, *y, *z;
};

// Rows of equal length, one for each component: one pointer in the loops that have many.
struct ForceRows {
  double* x;  // N
  std::size_t row;
  [[nodiscard]] double* component(std::size_t c) const noexcept { return x + c * row; }
};

// Forces of chunks on their second ends: value n, or the sum of both values.
struct ChunkForces {
  SegmentSprings springs;
  const double* value;  // N, [law][max_segment]
  bool has_two;         // laws
  const double* n;      // [component][max_segment], as in SegmentGeometry
  ForceRows force;      // by the chunks' places
  bool adds;            // to what is there
};

struct Kernels {
  void (*lengths)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  void (*lengths_and_rates)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  void (*relative_speeds)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  // Lengths alone, without directions.
  void (*distances)(const SegmentSprings& springs, const NodeArrays& nodes, SegmentGeometry& out);
  // The first three of springs given by the differences of their ends.
  void (*lengths_of)(const EndChanges& changes, std::size_t count, SegmentGeometry& out);
  void (*lengths_and_rates_of)(const EndChanges& changes, std::size_t count, SegmentGeometry& out);
  void (*relative_speeds_of)(const EndChanges& changes, std::size_t count, SegmentGeometry& out);
  // Gives slots without a spring the length and rate, or the speed, of the slot `living`, so that laws meet nothing
  // that no spring has. In chunks with a spring they have those of the first one already. What laws answer there is
  // left out of all forces.
  void (*settle_dead)(const SegmentSprings& springs, std::size_t living, SegmentGeometry& geometry);
  void (*settle_dead_speeds)(const SegmentSprings& springs, std::size_t living, SegmentGeometry& geometry);
  void (*chunk_forces)(const ChunkForces& forces);
  // The same, and `lengths` or `lengths_and_rates` of other chunks between, which wait for square roots.
  void (*chunk_forces_and_lengths)(const ChunkForces& forces, const SegmentSprings& springs, const NodeArrays& nodes,
                                   SegmentGeometry& out);
  void (*chunk_forces_and_lengths_and_rates)(const ChunkForces& forces, const SegmentSprings& springs,
                                             const NodeArrays& nodes, SegmentGeometry& out);
  // Sums up the forces `of_chunks` on their ends, eight nodes at a time: what one node receives from chunks that begin
  // anywhere would else go through memory that was just written in other pieces.
  void (*sum_chunk_forces)(const NodeSum* sums, std::size_t count, const std::uint32_t* places,
                           const ForceRows& of_chunks, const ForceArrays& force);
  // Subtracts (value + value_2) times the direction from the forces on the first ends and adds it to those on the
  // second ends. value_2 may be null. Of springs by their ends, on the first ends alone:
  void (*scatter_first)(const SegmentSprings& springs, const double* value, const double* value_2, const Directions& n,
                        const ForceArrays& force, std::uint32_t origin);
  // Of springs by their ends, in a window:
  void (*scatter_window)(const SegmentSprings& springs, const double* value, const double* value_2, const Directions& n,
                         const Window& window);
  // First ends minus second ends in a window, [component][spring]: positions, velocities, in rows of max_segment.
  void (*subtract_window)(const SegmentSprings& springs, const Window& window, double (*changes)[max_segment]);
  // Copies nodes [begin, end) to a window and clears their forces there; adds their forces there to those in arrays
  // that begin at node `origin`.
  void (*fill_window)(const NodeArrays& nodes, std::uint32_t begin, std::uint32_t end, const Window& window);
  void (*drain_window)(const Window& window, std::uint32_t begin, std::uint32_t end, const ForceArrays& force,
                       std::uint32_t origin);
  // force = mass gravity + load, [count]; load: null for none.
  void (*weigh)(std::size_t count, const double* mass, const double gravity[3], const double* const load[3],
                double* const force[3]);
  // Whether all are above 0: a multiple of chunk_springs.
  bool (*all_positive)(const double* values, std::size_t count);
  // Whether all numbers of three arrays are finite.
  bool (*all_finite)(const double* x, const double* y, const double* z, std::size_t count);
  ElementKernels elements;
  SeveralKernels several;
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
