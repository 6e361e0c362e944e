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
    mask[segment.mask_begin + slot / 64] |= std::uint64_t{1} << (slot % 64);
    ++segment.dead;
    --live;
    if (slot == segment.living && segment.dead < segment.count)
      segment.living = static_cast<std::uint32_t>(
          std::find_if(begin, end, [](std::uint32_t other) { return other != no_spring; }) - begin);
    return;
  }
}

void settle_dead(const Unit& unit, const Segment& segment, SegmentGeometry& g) noexcept {
  if (segment.dead == 0) return;
  const std::uint64_t* const words = unit.mask.data() + segment.mask_begin;
  const std::uint32_t living = segment.living;
  const double length = g.length[living], rate = g.rate[living], speed = g.speed[living];
  for (std::uint32_t w = 0; w < (segment.count + 63) / 64; ++w) {
    for (std::uint64_t word = words[w]; word != 0; word &= word - 1) {
      const std::uint32_t i = 64 * w + static_cast<std::uint32_t>(std::countr_zero(word));
      g.length[i] = length;
      g.rate[i] = rate;
      g.speed[i] = speed;
      g.nx[i] = g.ny[i] = g.nz[i] = 0.0;
      g.sx[i] = g.sy[i] = g.sz[i] = 0.0;
    }
  }
}

SegmentColumns::SegmentColumns(const Unit& unit, const Segment& segment, const Group& group) noexcept {
  const double* next = unit.values.data() + segment.value_begin;
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    columns_[c] = group.is_same(c) ? nullptr : next;
    if (!group.is_same(c)) next += segment.count;
  }
}

}  // namespace springnet::layers
