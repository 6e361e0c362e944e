// The springs of one segment of a tile: geometry by the kernels, laws a batch at a time, forces back to the nodes.

#include "layers/evaluator.hpp"

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

  alignas(64) double values[2][max_segment];
  const double* axial[2] = {nullptr, nullptr};
  std::size_t axial_count = 0;
  for (const Law* law : {&group.spring, &group.viscosity}) {
    if (!*law) continue;
    double* value = values[law == &group.viscosity];
    LawOutputs out;
    out.force = value;
    const springnet_status status =
        call_law(group, *law, abi_number(set_), time, segment.count, rows,
                 law->relative ? geometry.speed : geometry.length, geometry.rate, out, &message);
    if (status != SPRINGNET_OK) return status;
    if (law->relative)
      kernels_.scatter_relative(springs, geometry, value, to_second, force);
    else
      axial[axial_count++] = value;
  }
  if (axial_count > 0) kernels_.scatter_axial(springs, geometry, axial[0], axial[1], to_second, force);
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
