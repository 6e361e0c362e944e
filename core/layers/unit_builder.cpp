#include "layers/unit_builder.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

#include "layers/ordering.hpp"

namespace springnet::layers {
namespace {

// Springs that make a run, where others are read through indices; fewer are faster that way.
constexpr std::uint32_t common_run = 8;
// Share of a unit's springs below which all are in runs: springs read through indices cost something for every node.
constexpr double few_listed = 0.15;
// Nodes without a spring that a run bridges, as long as half of its slots have one.
constexpr std::uint32_t longest_gap = 3;
// Springs of a tile with equal parameters that make a segment of their own, whose law reads one value per parameter.
constexpr std::size_t smallest_uniform = 24;

std::uint32_t offset(const UnitSpring& s) noexcept { return s.other - s.own; }  // of springs that are not far

}  // namespace

void UnitBuilder::build(Unit& unit, std::span<UnitSpring> springs) {
  unit_ = &unit;
  springs_ = springs;
  sets_.clear();
  pieces_.clear();
  unit.halo = unit.reach = unit.window = 0;
  unit.live = springs.size();
  for (auto* list : {&unit.first, &unit.second, &unit.spring}) list->clear();
  unit.tiles.clear();
  unit.segments.clear();
  unit.runs.clear();
  unit.mask.clear();
  unit.values.clear();

  const auto tile_of = [&](const UnitSpring& s) { return (s.own - unit.first_node) / tile_nodes; };
  std::sort(springs.begin(), springs.end(), [&](const UnitSpring& s, const UnitSpring& t) {
    return std::tuple(tile_of(s), s.is_far, s.group, s.row, s.spring) <
           std::tuple(tile_of(t), t.is_far, t.group, t.row, t.spring);
  });
  std::vector<std::size_t> first_set{0};  // [tile + 1]
  std::size_t begin = 0;
  for (std::uint32_t first = 0; first < unit.node_count; first += tile_nodes) {
    std::size_t end = begin;
    while (end < springs.size() && tile_of(springs[end]) == first / tile_nodes) ++end;
    find_sets(begin, end);
    for (std::size_t i = begin; i < end; ++i) {
      const UnitSpring& s = springs[i];
      if (s.is_far) continue;
      unit.reach = std::max(unit.reach, s.other - (unit.first_node + first) + 1);
      if (s.other >= unit.end_node()) unit.halo = std::max(unit.halo, s.other - unit.end_node() + 1);
    }
    begin = end;
    first_set.push_back(sets_.size());
  }
  std::size_t listed = 0;
  for (const Piece& piece : pieces_) listed += piece.end - piece.begin < common_run ? piece.end - piece.begin : 0;
  const bool few = static_cast<double>(listed) <= few_listed * static_cast<double>(springs.size());
  shortest_run_ = few ? 1 : common_run;
  if (!few) unit.window = std::bit_ceil(std::max(unit.reach, tile_nodes));

  for (std::uint32_t t = 0; t + 1 < first_set.size(); ++t) {
    Tile tile{};
    tile.first_node = unit.first_node + t * tile_nodes;
    tile.node_count = std::min(tile_nodes, unit.end_node() - tile.first_node);
    tile.segment_begin = static_cast<std::uint32_t>(unit.segments.size());
    for (std::size_t i = first_set[t]; i < first_set[t + 1]; ++i) {
      add_runs(sets_[i], false);
      add_runs(sets_[i], true);
      add_listed(sets_[i]);
    }
    tile.segment_end = static_cast<std::uint32_t>(unit.segments.size());
    unit.tiles.push_back(tile);
  }
  for (auto* list : {&unit.first, &unit.second, &unit.spring}) list->shrink_to_fit();
  unit.segments.shrink_to_fit();
  unit.runs.shrink_to_fit();
  unit.mask.shrink_to_fit();
  unit.values.shrink_to_fit();
}

// Of a tile's springs, sorted by group and row: frequent rows are sets of their own, the others mixed ones.
void UnitBuilder::find_sets(std::size_t begin, std::size_t end) {
  while (begin < end) {
    const auto same_laws = [&](std::size_t i) {
      return springs_[i].group == springs_[begin].group && springs_[i].is_far == springs_[begin].is_far;
    };
    std::size_t all = begin;
    while (all < end && same_laws(all)) ++all;
    // Move the springs of rare rows behind the others.
    mixed_.clear();
    std::size_t kept = begin;
    bool one_row = true;
    for (std::size_t i = begin; i < all;) {
      std::size_t stop = i + 1;
      while (stop < all && springs_[stop].row == springs_[i].row) ++stop;
      if (stop - i >= smallest_uniform) {
        std::copy(springs_.begin() + static_cast<std::ptrdiff_t>(i), springs_.begin() + static_cast<std::ptrdiff_t>(stop),
                  springs_.begin() + static_cast<std::ptrdiff_t>(kept));
        add_set(kept, kept + (stop - i), springs_[kept].row);
        kept += stop - i;
      } else {
        one_row = one_row && (mixed_.empty() || mixed_.front().row == springs_[i].row);
        mixed_.insert(mixed_.end(), springs_.begin() + static_cast<std::ptrdiff_t>(i),
                      springs_.begin() + static_cast<std::ptrdiff_t>(stop));
      }
      i = stop;
    }
    std::copy(mixed_.begin(), mixed_.end(), springs_.begin() + static_cast<std::ptrdiff_t>(kept));
    if (kept < all) add_set(kept, all, one_row ? springs_[kept].row : mixed_rows);
    begin = all;
  }
}

void UnitBuilder::add_set(std::size_t begin, std::size_t end, std::uint32_t row) {
  Set set{begin, end, row, pieces_.size(), pieces_.size()};
  if (!springs_[begin].is_far) find_pieces(set);
  sets_.push_back(set);
}

void UnitBuilder::find_pieces(Set& set) {
  const auto at = [this](std::size_t i) { return springs_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::sort(at(set.begin), at(set.end), [](const UnitSpring& s, const UnitSpring& t) {
    return std::tuple(offset(s), s.own, s.spring) < std::tuple(offset(t), t.own, t.spring);
  });
  const auto is_across = [this](const UnitSpring& s) { return s.other >= unit_->end_node(); };
  for (std::size_t begin = set.begin; begin < set.end;) {
    std::size_t end = begin + 1;
    for (; end < set.end; ++end) {
      const UnitSpring &last = springs_[end - 1], &next = springs_[end];
      if (offset(next) != offset(last) || next.own == last.own || next.own - last.own > longest_gap + 1 ||
          is_across(next) != is_across(last) || next.own - springs_[begin].own >= 2 * (end - begin + 1))
        break;
    }
    pieces_.push_back({begin, end, springs_[end - 1].own - springs_[begin].own + 1, is_across(springs_[begin])});
    begin = end;
  }
  set.piece_end = pieces_.size();
}

Segment& UnitBuilder::begin_segment(const UnitSpring& one, std::uint32_t row, Reach reach) {
  Segment& segment = unit_->segments.emplace_back();
  segment = {};
  segment.group = one.group;
  segment.row = row;
  segment.begin = static_cast<std::uint32_t>(unit_->spring.size());
  segment.run_begin = static_cast<std::uint32_t>(unit_->runs.size());
  segment.end_begin = static_cast<std::uint32_t>(unit_->first.size());
  segment.mask_begin = static_cast<std::uint32_t>(unit_->mask.size());
  segment.value_begin = unit_->values.size();
  segment.reach = reach;
  return segment;
}

// slots: [slot], null for those without a spring; the first one has one.
void UnitBuilder::end_segment(std::span<const UnitSpring* const> slots) {
  Segment& segment = unit_->segments.back();
  segment.count = static_cast<std::uint32_t>(slots.size());
  unit_->mask.resize(segment.mask_begin + (slots.size() + 63) / 64, 0);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    unit_->spring.push_back(slots[i] != nullptr ? slots[i]->spring : no_spring);
    if (slots[i] != nullptr) {
      segment.living = static_cast<std::uint32_t>(i);
      continue;
    }
    unit_->mask[segment.mask_begin + i / 64] |= std::uint64_t{1} << (i % 64);
    ++segment.dead;
  }
  if (segment.row != mixed_rows) return;
  const Group& group = groups_[segment.group];
  std::uint32_t row = slots[segment.living]->row;
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    if (group.is_same(c)) continue;
    for (const UnitSpring* const spring : slots) {
      if (spring != nullptr) row = spring->row;
      unit_->values.push_back(group.columns[c][row]);
    }
  }
}

void UnitBuilder::add_runs(const Set& set, bool is_across) {
  slots_.clear();
  for (std::size_t p = set.piece_begin; p < set.piece_end; ++p) {
    const Piece& piece = pieces_[p];
    if (piece.is_across != is_across || piece.end - piece.begin < shortest_run_) continue;
    const std::uint32_t own = springs_[piece.begin].own, distance = offset(springs_[piece.begin]);
    std::size_t next = piece.begin;
    for (std::uint32_t i = 0; i < piece.slots; ++i) {
      if (slots_.size() == max_segment) {
        end_segment(slots_);
        slots_.clear();
      }
      const bool is_new = slots_.empty();
      if (is_new) begin_segment(springs_[next], set.row, is_across ? Reach::across : Reach::within);
      if (is_new || i == 0) {
        unit_->runs.push_back({own + i, own + i + distance, 0});
        ++unit_->segments.back().run_count;
      }
      ++unit_->runs.back().count;
      const bool has_spring = springs_[next].own == own + i;
      slots_.push_back(has_spring ? &springs_[next] : nullptr);
      next += has_spring ? 1 : 0;
    }
  }
  if (!slots_.empty()) end_segment(slots_);
}

// Springs in no run, by their ends. The first ones of all nodes come before the second ones, and so on: an end is not
// that of the spring before, whose force may still be on its way to memory.
void UnitBuilder::add_listed(const Set& set) {
  listed_.clear();
  const bool is_far = springs_[set.begin].is_far;
  const auto take = [&](std::size_t begin, std::size_t end) {
    listed_.insert(listed_.end(), springs_.begin() + static_cast<std::ptrdiff_t>(begin),
                   springs_.begin() + static_cast<std::ptrdiff_t>(end));
  };
  if (is_far) take(set.begin, set.end);
  for (std::size_t p = set.piece_begin; p < set.piece_end; ++p)
    if (pieces_[p].end - pieces_[p].begin < shortest_run_) take(pieces_[p].begin, pieces_[p].end);
  std::sort(listed_.begin(), listed_.end(), [](const UnitSpring& s, const UnitSpring& t) {
    return std::tuple(s.own, s.other, s.spring) < std::tuple(t.own, t.other, t.spring);
  });
  slots_.clear();
  for (std::uint32_t round = 0; slots_.size() < listed_.size(); ++round) {
    for (std::size_t begin = 0; begin < listed_.size();) {
      std::size_t end = begin + 1;
      while (end < listed_.size() && listed_[end].own == listed_[begin].own) ++end;
      if (begin + round < end) slots_.push_back(&listed_[begin + round]);
      begin = end;
    }
  }
  for (std::size_t begin = 0; begin < slots_.size(); begin += max_segment) {
    const std::size_t end = std::min(slots_.size(), begin + max_segment);
    begin_segment(*slots_[begin], set.row, is_far ? Reach::far : Reach::near);
    for (std::size_t i = begin; i < end; ++i) {
      unit_->first.push_back(slots_[i]->own);
      unit_->second.push_back(slots_[i]->other);
    }
    end_segment(std::span(slots_).subspan(begin, end - begin));
  }
}

}  // namespace springnet::layers
