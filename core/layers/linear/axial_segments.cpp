#include "layers/linear/axial_segments.hpp"

#include <omp.h>

namespace springnet::layers {

void AxialSegments::reserve() {
  while (scratch_.size() < evaluator_.threads()) scratch_.push_back(std::make_unique<Scratch>());
}

AxialSegments::Scratch& AxialSegments::own_scratch() const {
  return *scratch_[static_cast<std::size_t>(omp_get_thread_num())];
}

bool AxialSegments::answer(const Unit& unit, const Segment& segment, double time, const NodeArrays& nodes,
                           const std::vector<std::uint32_t>& places, Scratch& scratch, AxialAnswers& answers) const {
  const Kernels& kernels = kernels_for(evaluator_.instruction_set());
  const Group& group = layout_.laws().groups[segment.group];
  const SegmentSprings springs = unit.springs_of(segment);
  SegmentGeometry& g = scratch.geometry;
  kernels.lengths_and_rates(springs, nodes, g);
  kernels.relative_speeds(springs, nodes, g);
  if (Unit::is_unsettled(segment)) {
    kernels.settle_dead(springs, segment.living, g);
    kernels.settle_dead_speeds(springs, segment.living, g);
  }
  const SegmentColumns columns(unit, segment, group);
  const RowSelection rows =
      segment.row == mixed_rows ? RowSelection{nullptr, 0, columns.data()} : RowSelection{nullptr, segment.row};
  const LawBatch batch{group,
                       segment.count,
                       rows,
                       g.length,
                       g.rate,
                       g.speed,
                       {layout_.internal(), segment.group, nodes, unit.internal_of(segment)},
                       nullptr,
                       {CalledMembers::Are::springs, segment.count, 1, unit.spring.data() + segment.begin}};
  springnet_message message{};
  const PairOutputs out = scratch.answers.outputs(true, false);
  if (evaluate_laws(batch, evaluator_.instruction_set(), time, out, message) != SPRINGNET_OK) return false;
  answers = {unit.spring.data() + segment.begin,
             places.data() + segment.begin,
             segment.count,
             {g.nx, g.ny, g.nz},
             {g.sx, g.sy, g.sz},
             g.length,
             g.rate,
             g.speed,
             {},
             {},
             {}};
  for (std::size_t k = 0; k < 2; ++k) {
    if (!*group.laws()[k]) continue;
    answers.tension[k] = scratch.answers.force[k];
    answers.by_length[k] = scratch.answers.by_q[k];
    answers.by_rate[k] = scratch.answers.by_rate[k];
  }
  return true;
}

}  // namespace springnet::layers
