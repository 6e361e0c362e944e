// The springs of one segment of a tile: geometry, laws, forces back to the nodes.

#include "layers/evaluator.hpp"
#include "layers/law_pair.hpp"
#include "layers/unit_scratch.hpp"

namespace springnet::layers {
namespace {

void find_geometry(const Kernels& kernels, const Unit& unit, const Segment& segment, const Group& group,
                   const NodeArrays& nodes, UnitScratch& scratch) {
  const SegmentSprings springs = unit.springs_of(segment);
  SegmentGeometry& geometry = scratch.geometry;
  const bool rates = group.spring.reads_rate || group.viscosity.reads_rate;
  const bool lengths = (group.spring && !group.spring.relative) || (group.viscosity && !group.viscosity.relative);
  const bool speeds = group.spring.relative || group.viscosity.relative;
  if (segment.access == Access::near) {
    kernels.subtract_window(springs, scratch.window, scratch.changes);
    const auto& c = scratch.changes;
    const EndChanges changes{c[0], c[1], c[2], c[3], c[4], c[5]};
    if (rates)
      kernels.lengths_and_rates_of(changes, segment.count, geometry);
    else if (lengths)
      kernels.lengths_of(changes, segment.count, geometry);
    if (speeds) kernels.relative_speeds_of(changes, segment.count, geometry);
  } else {
    if (rates)
      kernels.lengths_and_rates(springs, nodes, geometry);
    else if (lengths)
      kernels.lengths(springs, nodes, geometry);
    if (speeds) kernels.relative_speeds(springs, nodes, geometry);
  }
  if (segment.dead > 0)
    kernels.settle_dead(unit.live_in(segment), segment.count, segment.living, geometry);
}

}  // namespace

springnet_status Evaluator::evaluate_segment(const Unit& unit, const Segment& segment, double time,
                                             const NodeArrays& nodes, UnitScratch& scratch,
                                             springnet_message& message) const {
  if (segment.dead == segment.count) return SPRINGNET_OK;
  const Group& group = layout_.laws().groups[segment.group];
  find_geometry(kernels_, unit, segment, group, nodes, scratch);

  alignas(64) double force_of[2][max_segment];  // [law]
  const SegmentGeometry& g = scratch.geometry;
  const PairOutputs out{LawOutputs{force_of[0]}, LawOutputs{force_of[1]}};
  springnet_status status = SPRINGNET_OK;
  if (segment.row == mixed_rows) {
    const SegmentColumns columns(unit, segment, group);
    status = evaluate_laws({group, segment.count, {nullptr, 0, columns.data()}, g.length, g.rate, g.speed}, set_, time,
                           out, message);
  } else {
    status = evaluate_laws({group, segment.count, {nullptr, segment.row}, g.length, g.rate, g.speed}, set_, time, out,
                           message);
  }
  if (status != SPRINGNET_OK) return status;

  const SegmentSprings springs = unit.springs_of(segment);
  const auto scatter = [&](const double* value, const double* value_2, const Directions& directions) {
    switch (segment.access) {
      case Access::chunks:
        return kernels_.scatter_chunks(springs, value, value_2, directions, scratch.force, unit.first_node);
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
