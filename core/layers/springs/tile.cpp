// The springs of one segment of a tile: geometry, laws, forces back to the nodes.

#include <algorithm>
#include <cstddef>
#include <utility>

#include "layers/evaluator.hpp"
#include "layers/law_pair.hpp"
#include "layers/unit_scratch.hpp"

namespace springnet::layers {
namespace {

// ChunkForces reads directions by one pointer.
static_assert(offsetof(SegmentGeometry, ny) == offsetof(SegmentGeometry, nx) + sizeof(double) * max_segment);
static_assert(offsetof(SegmentGeometry, nz) == offsetof(SegmentGeometry, ny) + sizeof(double) * max_segment);
static_assert(offsetof(SegmentGeometry, sy) == offsetof(SegmentGeometry, sx) + sizeof(double) * max_segment);
static_assert(offsetof(SegmentGeometry, sz) == offsetof(SegmentGeometry, sy) + sizeof(double) * max_segment);

struct Wanted {
  bool lengths, rates, speeds;
  explicit Wanted(const Group& group) noexcept
      : lengths((group.spring && !group.spring.relative) || (group.viscosity && !group.viscosity.relative)),
        rates(group.spring.reads_rate || group.viscosity.reads_rate),
        speeds(group.spring.relative || group.viscosity.relative) {}
};

void find_by_window(const Kernels& kernels, const SegmentSprings& springs, const Wanted& wanted, UnitScratch& scratch,
                    SegmentGeometry& geometry) {
  kernels.subtract_window(springs, scratch.window, scratch.changes);
  const auto& c = scratch.changes;
  const EndChanges changes{c[0], c[1], c[2], c[3], c[4], c[5]};
  if (wanted.rates)
    kernels.lengths_and_rates_of(changes, springs.count, geometry);
  else if (wanted.lengths)
    kernels.lengths_of(changes, springs.count, geometry);
  if (wanted.speeds) kernels.relative_speeds_of(changes, springs.count, geometry);
}

void find_by_arrays(const Kernels& kernels, const SegmentSprings& springs, const Wanted& wanted,
                    const NodeArrays& nodes, SegmentGeometry& geometry) {
  if (wanted.rates)
    kernels.lengths_and_rates(springs, nodes, geometry);
  else if (wanted.lengths)
    kernels.lengths(springs, nodes, geometry);
  if (wanted.speeds) kernels.relative_speeds(springs, nodes, geometry);
}

}  // namespace

void Evaluator::sum_up(const Unit& unit, UnitScratch& scratch) const noexcept {
  if (scratch.unsummed == nullptr) return;
  const Tile& tile = *std::exchange(scratch.unsummed, nullptr);
  kernels_.sum_chunk_forces(unit.sums.data() + tile.sum_begin, tile.sum_end - tile.sum_begin,
                            unit.places.data() + tile.place_begin, scratch.chunk_force, scratch.force);
}

void Evaluator::settle_pending(const Unit& unit, UnitScratch& scratch) const noexcept {
  if (scratch.pending.springs.count > 0) kernels_.chunk_forces(scratch.pending);
  scratch.pending.springs.count = 0;
  sum_up(unit, scratch);
}

// A segment of chunks whose springs were all removed.
void Evaluator::clear_forces(const Unit& unit, const Segment& segment, UnitScratch& scratch) const noexcept {
  settle_pending(unit, scratch);
  const SegmentSprings springs = unit.springs_of(segment);
  if (springs.chunks == nullptr) return;
  for (std::uint32_t k = 0; k < springs.count / chunk_springs; ++k)  // a chunk, and the zeros that may follow it
    for (std::size_t c = 0; c < 3; ++c)
      std::fill_n(scratch.chunk_force.component(c) + springs.chunks[k].place,
                  (springs.chunks[k].is_last ? 2 : 1) * chunk_springs, 0.0);
}

// The forces of the segment before become final meanwhile, and reach the nodes if it was the last one of its tile.
void Evaluator::find_geometry(const Unit& unit, const Segment& segment, const NodeArrays& nodes,
                              UnitScratch& scratch) const noexcept {
  const Wanted wanted(layout_.laws().groups[segment.group]);
  const SegmentSprings springs = unit.springs_of(segment);
  scratch.turn ^= 1u;
  SegmentGeometry& geometry = scratch.springs[scratch.turn].geometry;
  const bool is_pending = scratch.pending.springs.count > 0;
  if (is_pending && segment.access == Access::chunks && wanted.lengths && !wanted.speeds) {
    if (wanted.rates)
      kernels_.chunk_forces_and_lengths_and_rates(scratch.pending, springs, nodes, geometry);
    else
      kernels_.chunk_forces_and_lengths(scratch.pending, springs, nodes, geometry);
    scratch.pending.springs.count = 0;
    sum_up(unit, scratch);
  } else {
    settle_pending(unit, scratch);
    if (segment.access == Access::near)
      find_by_window(kernels_, springs, wanted, scratch, geometry);
    else
      find_by_arrays(kernels_, springs, wanted, nodes, geometry);
  }
  if (!Unit::is_unsettled(segment)) return;
  if (wanted.lengths || wanted.rates) kernels_.settle_dead(springs, segment.living, geometry);
  if (wanted.speeds) kernels_.settle_dead_speeds(springs, segment.living, geometry);
}

// After find_geometry(). Forces along the springs of chunks are pending afterwards.
springnet_status Evaluator::apply_laws(const Unit& unit, const Segment& segment, double time, const NodeArrays& nodes,
                                       UnitScratch& scratch, springnet_message& message) const {
  const Group& group = layout_.laws().groups[segment.group];
  const SegmentGeometry& g = scratch.springs[scratch.turn].geometry;
  double(&force_of)[2][max_segment] = scratch.springs[scratch.turn].force;
  const PairOutputs out{LawOutputs{force_of[0]}, LawOutputs{force_of[1]}};
  const InternalSelection internal(layout_.internal(), segment.group, nodes, unit.internal_of(segment));
  const CalledMembers members{CalledMembers::Are::springs, segment.count, 1, unit.spring.data() + segment.begin};
  springnet_status status = SPRINGNET_OK;
  if (segment.row == mixed_rows) {
    const SegmentColumns columns(unit, segment, group);
    status = evaluate_laws(
        {group, segment.count, {nullptr, 0, columns.data()}, g.length, g.rate, g.speed, internal, nullptr, members},
        set_, time, out, message);
  } else {
    status = evaluate_laws(
        {group, segment.count, {nullptr, segment.row}, g.length, g.rate, g.speed, internal, nullptr, members}, set_,
        time, out, message);
  }
  if (status != SPRINGNET_OK) return status;

  const SegmentSprings springs = unit.springs_of(segment);
  bool is_second = false;
  const auto scatter = [&](const double* value, const double* value_2, const Directions& directions) {
    switch (segment.access) {
      case Access::chunks:
        settle_pending(unit, scratch);
        scratch.pending = {springs, value, value_2 != nullptr, directions.x, scratch.chunk_force, is_second};
        is_second = true;
        return;
      case Access::near:
        return kernels_.scatter_window(springs, value, value_2, directions, scratch.window);
      case Access::far:
        return kernels_.scatter_first(springs, value, value_2, directions, scratch.force, unit.first_node);
    }
  };
  const double* axial[2] = {nullptr, nullptr};
  std::size_t axial_count = 0;
  const std::array<const Law*, 2> laws = group.laws();
  for (std::size_t k = 0; k < laws.size(); ++k) {
    if (!*laws[k]) continue;
    if (laws[k]->relative)
      scatter(force_of[k], nullptr, {g.sx, g.sy, g.sz});
    else
      axial[axial_count++] = force_of[k];
  }
  if (axial_count > 0) scatter(axial[0], axial[1], {g.nx, g.ny, g.nz});
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
