#include "layers/springs/rupture.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include <springnet/sdk/message.hpp>

#include "layers/law_pair.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

struct RuptureSearch {
  const Layout& layout;
  InstructionSet set;
  double time;
  const NodeArrays& nodes;
};

// What the laws of a segment's springs read.
void find_geometry(const RuptureSearch& search, const Unit& unit, const Segment& segment, const Group& group,
                   SegmentGeometry& geometry) {
  const Kernels& kernels = kernels_for(search.set);
  const SegmentSprings springs = unit.springs_of(segment);
  bool rates = false, lengths = false, speeds = false;
  for (const Law* const law : group.laws()) {
    if (!law->can(SPRINGNET_HAS_RUPTURE)) continue;
    rates = rates || law->reads_rate;
    speeds = speeds || law->relative;
    lengths = lengths || !law->relative;
  }
  if (rates)
    kernels.lengths_and_rates(springs, search.nodes, geometry);
  else if (lengths)
    kernels.distances(springs, search.nodes, geometry);
  if (speeds) kernels.relative_speeds(springs, search.nodes, geometry);
  if (Unit::is_unsettled(segment)) {
    kernels.settle_dead(springs, segment.living, geometry);
    kernels.settle_dead_speeds(springs, segment.living, geometry);
  }
}

springnet_status find_in_segment(const RuptureSearch& search, std::uint32_t index, const Segment& segment,
                                 SegmentGeometry& geometry, std::vector<std::uint32_t>& broken,
                                 springnet_message& message) {
  const Unit& unit = search.layout.units()[index];
  const Group& group = search.layout.laws().groups[segment.group];
  if (segment.dead == segment.count || !group.can(SPRINGNET_HAS_RUPTURE)) return SPRINGNET_OK;
  find_geometry(search, unit, segment, group, geometry);
  alignas(64) double margins[2][max_segment];
  PairOutputs out{};
  for (std::size_t k = 0; k < out.size(); ++k)
    if (group.laws()[k]->can(SPRINGNET_HAS_RUPTURE)) out[k].margin = margins[k];
  const bool mixed = segment.row == mixed_rows;
  const SegmentColumns columns(unit, segment, group);
  const RowSelection rows{nullptr, mixed ? 0 : segment.row, mixed ? columns.data() : nullptr};
  const springnet_status status =
      evaluate_laws({group,
                     segment.count,
                     rows,
                     geometry.length,
                     geometry.rate,
                     geometry.speed,
                     {search.layout.internal(), segment.group, search.nodes, unit.internal_of(segment)},
                     nullptr,
                     {CalledMembers::Are::springs, segment.count, 1, unit.spring.data() + segment.begin}},
                    search.set, search.time, out, message);
  if (status != SPRINGNET_OK) return status;
  for (const LawOutputs& law : out) {
    if (law.margin == nullptr) continue;
    if (kernels_for(search.set).all_positive(law.margin, segment.count)) continue;  // in most segments
    for (std::size_t i = 0; i < segment.count; ++i) {
      const std::uint32_t s = unit.spring[segment.begin + i];
      if (law.margin[i] > 0.0 || s == no_spring) continue;
      if (std::isnan(law.margin[i])) return SPRINGNET_RECOVERABLE;
      broken.push_back(s);
    }
  }
  return SPRINGNET_OK;
}

}  // namespace

bool can_rupture(const Layout& layout) noexcept {
  const std::vector<Group>& groups = layout.laws().groups;
  return std::any_of(groups.begin(), groups.end(), [](const Group& group) { return group.can(SPRINGNET_HAS_RUPTURE); });
}

springnet_status broken_springs(const Layout& layout, InstructionSet set, unsigned threads, double time,
                                const NodeArrays& nodes, std::vector<std::uint32_t>& broken,
                                springnet_message& message) {
  const RuptureSearch search{layout, set, time, nodes};
  const auto units = static_cast<std::int64_t>(layout.units().size());
  std::int64_t failed_unit = units;
  springnet_status failure = SPRINGNET_OK;
  std::exception_ptr no_memory;
  broken.clear();
  const profile::Region region(threads);
#pragma omp parallel num_threads(static_cast <int>(threads)) if (threads > 1)
  {
    const FlushDenormals flush;
    const profile::Share share(region, omp_get_thread_num(), omp_get_num_threads());
    SegmentGeometry geometry;  // not initialised: written before it is read
    std::vector<std::uint32_t> own;
#pragma omp for schedule(static) nowait
    for (std::int64_t u = 0; u < units; ++u) {
      const profile::Tile measured;
      const profile::Part part("rupture");
      springnet_message unit_message{};
      // An exception that leaves the region would end the process.
      const springnet_status status = sdk::detail::guarded(&unit_message, [&]() -> springnet_status {
        for (const Segment& segment : layout.units()[static_cast<std::size_t>(u)].segments) {
          const springnet_status found =
              find_in_segment(search, static_cast<std::uint32_t>(u), segment, geometry, own, unit_message);
          if (found != SPRINGNET_OK) return found;
        }
        return SPRINGNET_OK;
      });
      if (status == SPRINGNET_OK) continue;
#pragma omp critical(springnet_rupture)
      if (u < failed_unit) {
        failed_unit = u;
        failure = status;
        message = unit_message;
      }
    }
#pragma omp critical(springnet_rupture)
    try {
      broken.insert(broken.end(), own.begin(), own.end());
    } catch (...) {
      no_memory = std::current_exception();
    }
  }
  if (no_memory) std::rethrow_exception(no_memory);
  std::sort(broken.begin(), broken.end());
  broken.erase(std::unique(broken.begin(), broken.end()), broken.end());  // far ones are in two units
  return failure;
}

}  // namespace springnet::layers
