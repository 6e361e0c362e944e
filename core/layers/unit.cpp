#include "layers/unit.hpp"

#include <algorithm>
#include <bit>

#include "layers/ordering.hpp"

namespace springnet::layers {

void Unit::remove(std::uint32_t own, std::uint32_t spring_number) {
  const Tile& tile = tiles[(own - first_node) / tile_nodes];
  for (std::uint32_t s = tile.segment_begin; s < tile.segment_end; ++s) {
    const std::uint32_t first_slot = segments[s].begin;
    const std::uint32_t* const list = spring.data() + first_slot;
    const std::uint32_t* const found = std::find(list, list + segments[s].count, spring_number);
    if (found == list + segments[s].count) continue;
    const auto slot = static_cast<std::uint32_t>(found - list);
    spring.own()[first_slot + slot] = no_spring;
    const auto begin = spring.begin() + first_slot, end = begin + segments[s].count;
    Segment& segment = segments.own()[s];
    std::uint8_t& live_slots = live_mask.own()[(first_slot + slot) / chunk_springs];
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

void Unit::settle_values(std::size_t index) {
  const Segment& segment = segments[index];
  const bool is_mixed = segment.row == mixed_rows;
  if ((!is_mixed && internal.empty()) || segment.dead == 0 || segment.dead == segment.count) return;
  const std::size_t value_count = is_mixed ? std::size_t{segment.value_columns} * segment.count : 0;
  std::vector<double>& own_values = values.own();
  std::vector<std::uint32_t>* const own_internal = internal.empty() ? nullptr : &internal.own();
  double* const columns_begin = own_values.data() + segment.value_begin;
  double* const columns_end = columns_begin + value_count;
  const std::uint8_t* const live_slots = live_in(segment);
  for (std::uint32_t at = 0; at < segment.count; at += chunk_springs) {
    const unsigned mask = live_slots[at / chunk_springs];
    const bool has_own = segment.access == Access::chunks && mask != 0;
    const std::uint32_t source = has_own ? at + static_cast<std::uint32_t>(std::countr_zero(mask)) : segment.living;
    for (std::uint32_t i = 0; i < chunk_springs; ++i) {
      if ((mask >> i & 1u) != 0) continue;
      for (double* column = columns_begin; column != columns_end; column += segment.count)
        column[at + i] = column[source];
      if (own_internal != nullptr)
        (*own_internal)[segment.begin + at + i] = (*own_internal)[segment.begin + source] | InternalLayout::silent;
    }
  }
}

void Unit::settle_value(std::size_t index, std::size_t column, std::uint32_t place) {
  const Segment& segment = segments[index];
  if (segment.dead == 0 || segment.dead == segment.count) return;
  if (place == segment.living) return settle_values(index);
  const std::uint32_t at = place / chunk_springs * chunk_springs;
  const unsigned mask = live_in(segment)[place / chunk_springs];
  if (segment.access != Access::chunks || mask == 0 || at + static_cast<std::uint32_t>(std::countr_zero(mask)) != place)
    return;
  double* const values_of_chunk = values.own().data() + segment.value_begin + column * segment.count + at;
  for (std::uint32_t i = 0; i < chunk_springs; ++i)
    if ((mask >> i & 1u) == 0) values_of_chunk[i] = values_of_chunk[place - at];
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
