#include "layers/unit.hpp"

#include <algorithm>
#include <bit>

#include "layers/ordering.hpp"

namespace springnet::layers {

void Unit::remove(std::uint32_t own, std::uint32_t spring_number) noexcept {
  const Tile& tile = tiles[(own - first_node) / tile_nodes];
  for (std::uint32_t s = tile.segment_begin; s < tile.segment_end; ++s) {
    Segment& segment = segments[s];
    const auto begin = spring.begin() + segment.begin, end = begin + segment.count;
    const auto found = std::find(begin, end, spring_number);
    if (found == end) continue;
    *found = no_spring;
    const auto slot = static_cast<std::uint32_t>(found - begin);
    std::uint8_t& live_slots = live_mask[(segment.begin + slot) / chunk_springs];
    live_slots &= static_cast<std::uint8_t>(~(1u << (slot % chunk_springs)));
    segment.has_empty_chunk = segment.has_empty_chunk || live_slots == 0;
    ++segment.dead;
    --live;
    if (slot == segment.living && segment.dead < segment.count)
      segment.living = static_cast<std::uint32_t>(
          std::find_if(begin, end, [](std::uint32_t other) { return other != no_spring; }) - begin);
    settle_values(s);
    return;
  }
}

void Unit::settle_values(std::size_t index) noexcept {
  const Segment& segment = segments[index];
  const bool is_mixed = segment.row == mixed_rows;
  if ((!is_mixed && internal.empty()) || segment.dead == 0 || segment.dead == segment.count) return;
  const std::size_t value_count = is_mixed ? std::size_t{segment.value_columns} * segment.count : 0;
  double* const columns_end = values.data() + segment.value_begin + value_count;
  const std::uint8_t* const live_slots = live_in(segment);
  for (std::uint32_t at = 0; at < segment.count; at += chunk_springs) {
    const unsigned mask = live_slots[at / chunk_springs];
    const bool has_own = segment.access == Access::chunks && mask != 0;
    const std::uint32_t source = has_own ? at + static_cast<std::uint32_t>(std::countr_zero(mask)) : segment.living;
    for (std::uint32_t i = 0; i < chunk_springs; ++i) {
      if ((mask >> i & 1u) != 0) continue;
      for (double* column = values.data() + segment.value_begin; column != columns_end; column += segment.count)
        column[at + i] = column[source];
      if (!internal.empty())
        internal[segment.begin + at + i] = internal[segment.begin + source] | InternalLayout::silent;
    }
  }
}

SegmentColumns::SegmentColumns(const Unit& unit, const Segment& segment, const Group& group) noexcept {
  const double* next = unit.values.data() + segment.value_begin;
  const bool all = segment.value_columns == group.columns.size();
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    const bool is_listed = all || group.differs[c] != 0;
    columns_[c] = is_listed ? next : nullptr;
    if (is_listed) next += segment.count;
  }
}

}  // namespace springnet::layers
