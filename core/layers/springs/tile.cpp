// The springs of one segment of a tile: geometry, laws, forces back to the nodes.

#include "layers/evaluator.hpp"
#include "layers/law_pair.hpp"

namespace springnet::layers {

springnet_status Evaluator::evaluate_segment(const Unit& unit, const Segment& segment, double time,
                                             const NodeArrays& nodes, const ForceArrays& force,
                                             SegmentGeometry& geometry, springnet_message& message) const {
  const Group& group = layout_.laws().groups[segment.group];
  const SegmentSprings springs{unit.runs.data() + segment.run_begin,
                               segment.run_count,
                               segment.run_springs,
                               segment.count,
                               unit.first.data() + segment.begin,
                               unit.second.data() + segment.begin};
  const RowSelection rows =
      segment.row == mixed_rows ? RowSelection{unit.row.data() + segment.begin, 0} : RowSelection{nullptr, segment.row};
  const bool to_second = !segment.boundary;
  if (group.spring.reads_rate || group.viscosity.reads_rate)
    kernels_.lengths_and_rates(springs, nodes, geometry);
  else if ((group.spring && !group.spring.relative) || (group.viscosity && !group.viscosity.relative))
    kernels_.lengths(springs, nodes, geometry);
  if (group.spring.relative || group.viscosity.relative) kernels_.relative_speeds(springs, nodes, geometry);

  alignas(64) double force_of[2][max_segment];  // [law]
  const LawBatch batch{group, segment.count, rows, geometry.length, geometry.rate, geometry.speed};
  const springnet_status status =
      evaluate_laws(batch, set_, time, {LawOutputs{force_of[0]}, LawOutputs{force_of[1]}}, message);
  if (status != SPRINGNET_OK) return status;

  const double* axial[2] = {nullptr, nullptr};
  std::size_t axial_count = 0;
  const std::array<const Law*, 2> laws = group.laws();
  for (std::size_t k = 0; k < laws.size(); ++k) {
    if (!*laws[k]) continue;
    if (laws[k]->relative)
      kernels_.scatter_relative(springs, geometry, force_of[k], to_second, force);
    else
      axial[axial_count++] = force_of[k];
  }
  if (axial_count > 0) kernels_.scatter_axial(springs, geometry, axial[0], axial[1], to_second, force);
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
