#include "layers/unit_builder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <tuple>

#include "layers/ordering.hpp"

namespace springnet::layers {
namespace {

// Springs that make a chunk, where others are read through indices; fewer are faster that way.
constexpr std::size_t common_chunk = 4;
// About what a chunk and a spring read through indices cost, and what a unit with such springs costs more for a node
// and for a tile: cycles.
constexpr std::size_t chunk_cost = 50, listed_cost = 16, window_cost = 12, call_cost = 300;
// Slots of a segment of chunks: the cache has to hold two at a time, and the nodes of the tile.
constexpr std::size_t most_chunk_slots = 256, most_chunk_slots_of_small_net = max_segment;
// Springs of a tile with equal parameters that make a segment of their own, whose law reads one value per parameter.
// In a net that the caches hold, a call of a law costs more than reading values.
constexpr std::size_t smallest_uniform = 24, smallest_uniform_of_small_net = 192, springs_of_small_net = 4096;

std::uint32_t offset(const UnitSpring& s) noexcept { return s.other - s.own; }  // of springs that are not far

// Sorts by a number; equal ones keep their order. Springs of a tile mostly have few numbers: their rows, their offsets.
template <class Key>
void sort_by(std::span<UnitSpring> springs, std::vector<UnitSpring>& copy, const Key& key) {
  constexpr std::size_t few = 16;
  std::array<std::uint64_t, few> keys;
  std::array<std::size_t, few> count{};
  std::size_t kinds = 0, last = 0;
  for (const UnitSpring& spring : springs) {
    const std::uint64_t own = key(spring);
    if (kinds == 0 || keys[last] != own) {
      last = static_cast<std::size_t>(std::find(keys.begin(), keys.begin() + kinds, own) - keys.begin());
      if (last == few) {
        std::stable_sort(springs.begin(), springs.end(),
                         [&](const UnitSpring& s, const UnitSpring& t) { return key(s) < key(t); });
        return;
      }
      if (last == kinds) keys[kinds++] = own;
    }
    ++count[last];
  }
  if (kinds < 2) return;
  std::array<std::size_t, few> order, place;
  std::iota(order.begin(), order.begin() + kinds, std::size_t{0});
  std::sort(order.begin(), order.begin() + kinds, [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
  std::size_t next = 0;
  for (std::size_t i = 0; i < kinds; ++i) {
    place[order[i]] = next;
    next += count[order[i]];
  }
  copy.assign(springs.begin(), springs.end());
  for (const UnitSpring& spring : copy) {
    const std::uint64_t own = key(spring);
    if (keys[last] != own) last = static_cast<std::size_t>(std::find(keys.begin(), keys.end(), own) - keys.begin());
    springs[place[last]++] = spring;
  }
}

}  // namespace

UnitBuilder::UnitBuilder(const std::vector<Group>& groups, std::uint32_t node_count, std::size_t spring_count)
    : groups_(groups),
      node_count_(node_count),
      smallest_uniform_(spring_count < springs_of_small_net ? smallest_uniform_of_small_net : smallest_uniform),
      most_chunk_slots_(spring_count < springs_of_small_net ? most_chunk_slots_of_small_net : most_chunk_slots) {}

void UnitBuilder::build(Unit& unit, std::span<UnitSpring> springs) {
  unit_ = &unit;
  springs_ = springs;
  sets_.clear();
  pieces_.clear();
  unit.halo = unit.reach = unit.window = 0;
  unit.live = unit.laid_out = springs.size();
  unit.forces = 0;
  for (auto* list : {&unit.first, &unit.second, &unit.spring, &unit.places}) list->clear();
  unit.tiles.clear();
  unit.segments.clear();
  unit.chunks.clear();
  unit.sums.clear();
  unit.live_mask.clear();
  unit.values.clear();
  unit.internal.clear();  // of another layout; whoever builds places the states anew

  // Springs by tile; those of a tile by what makes a set.
  const auto tile_of = [&](const UnitSpring& s) { return (s.own - unit.first_node) / tile_nodes; };
  std::vector<std::size_t> tile_start((unit.node_count + tile_nodes - 1) / tile_nodes + 1, 0);
  for (const UnitSpring& s : springs) ++tile_start[tile_of(s) + 1];
  std::partial_sum(tile_start.begin(), tile_start.end(), tile_start.begin());
  copy_.assign(springs.begin(), springs.end());
  std::vector<std::size_t> next(tile_start.begin(), tile_start.end() - 1);
  for (const UnitSpring& s : copy_) springs[next[tile_of(s)]++] = s;
  std::vector<std::size_t> first_set{0};  // [tile + 1]
  for (std::uint32_t first = 0; first < unit.node_count; first += tile_nodes) {
    const std::size_t begin = tile_start[first / tile_nodes], end = tile_start[first / tile_nodes + 1];
    const std::span<UnitSpring> of_tile = springs.subspan(begin, end - begin);
    sort_by(of_tile, copy_, [](const UnitSpring& s) { return s.row; });
    sort_by(of_tile, copy_, [](const UnitSpring& s) { return (std::uint64_t{s.is_far} << 32) | s.group; });
    find_sets(begin, end);
    for (std::size_t i = begin; i < end; ++i) {
      const UnitSpring& s = springs[i];
      if (s.is_far) continue;
      unit.reach = std::max(unit.reach, s.other - (unit.first_node + first) + 1);
      if (s.other >= unit.end_node()) unit.halo = std::max(unit.halo, s.other - unit.end_node() + 1);
    }
    first_set.push_back(sets_.size());
  }
  std::size_t small = 0, listed = window_cost * unit.node_count + call_cost * (first_set.size() - 1);
  for (const Piece& piece : pieces_) {
    if (piece.end - piece.begin >= common_chunk) continue;
    small += chunk_cost;
    listed += listed_cost * (piece.end - piece.begin);
  }
  all_in_chunks_ = small <= listed;
  // A window also serves springs at the end of the net that no chunk can hold.
  const bool any_listed =
      std::any_of(pieces_.begin(), pieces_.end(), [this](const Piece& piece) { return !is_chunk(piece); });
  if (any_listed) unit.window = std::bit_ceil(std::max(unit.reach, tile_nodes));

  for (std::uint32_t t = 0; t + 1 < first_set.size(); ++t) {
    Tile tile{};
    tile.first_node = unit.first_node + t * tile_nodes;
    tile.node_count = std::min(tile_nodes, unit.end_node() - tile.first_node);
    tile.segment_begin = static_cast<std::uint32_t>(unit.segments.size());
    runs_.clear();
    next_place_ = chunk_springs;
    for (std::size_t i = first_set[t]; i < first_set[t + 1]; ++i) {
      add_chunks(sets_[i]);
      add_listed(sets_[i]);
    }
    tile.segment_end = static_cast<std::uint32_t>(unit.segments.size());
    add_sums(tile);
    unit.tiles.push_back(tile);
  }
  for (auto* list : {&unit.first, &unit.second, &unit.spring, &unit.places}) list->own().shrink_to_fit();
  unit.sums.own().shrink_to_fit();
  unit.segments.own().shrink_to_fit();
  unit.chunks.own().shrink_to_fit();
  unit.live_mask.own().shrink_to_fit();
  unit.values.own().shrink_to_fit();
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
      if (stop - i >= smallest_uniform_) {
        std::copy(springs_.begin() + static_cast<std::ptrdiff_t>(i),
                  springs_.begin() + static_cast<std::ptrdiff_t>(stop),
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
  const std::span<UnitSpring> springs = springs_.subspan(set.begin, set.end - set.begin);
  const auto by_own = [](const UnitSpring& s, const UnitSpring& t) {
    return std::tuple(s.own, s.spring) < std::tuple(t.own, t.spring);
  };
  if (!std::is_sorted(springs.begin(), springs.end(), by_own)) std::sort(springs.begin(), springs.end(), by_own);
  sort_by(springs, copy_, offset);
  for (std::size_t begin = set.begin; begin < set.end;) {
    // All of a chunk are nodes of the net, though not all have such a spring.
    const std::uint32_t distance = offset(springs_[begin]);
    const std::uint32_t last = node_count_ < chunk_springs + distance ? 0 : node_count_ - chunk_springs - distance;
    const std::uint32_t block = springs_[begin].own / chunk_springs;
    const std::uint32_t first = std::min(block * chunk_springs, last);
    std::size_t end = begin + 1;
    while (end < set.end && offset(springs_[end]) == distance && springs_[end].own != springs_[end - 1].own &&
           springs_[end].own / chunk_springs == block)
      ++end;
    pieces_.push_back({begin, end, first, first + distance});
    begin = end;
  }
  set.piece_end = pieces_.size();
}

bool UnitBuilder::is_chunk(const Piece& piece) const noexcept {
  const bool fits = piece.second + chunk_springs <= node_count_;
  return fits && (all_in_chunks_ || piece.end - piece.begin >= common_chunk);
}

void UnitBuilder::begin_segment(const UnitSpring& one, std::uint32_t row, Access access) {
  Segment segment{};
  segment.group = one.group;
  segment.row = row;
  segment.begin = static_cast<std::uint32_t>(unit_->spring.size());
  segment.place = static_cast<std::uint32_t>(access == Access::chunks ? unit_->chunks.size() : unit_->first.size());
  segment.value_begin = unit_->values.size();
  segment.access = access;
  unit_->segments.push_back(segment);
  slots_.clear();
}

// Of slots_, which it fills up.
void UnitBuilder::end_segment() {
  slots_.resize((slots_.size() + chunk_springs - 1) / chunk_springs * chunk_springs, nullptr);
  Segment& segment = unit_->segments.own().back();
  segment.count = static_cast<std::uint32_t>(slots_.size());
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (i % chunk_springs == 0) unit_->live_mask.push_back(0);
    unit_->spring.push_back(slots_[i] != nullptr ? slots_[i]->spring : no_spring);
    if (slots_[i] != nullptr) {
      segment.living = static_cast<std::uint32_t>(i);
      unit_->live_mask.own().back() |= static_cast<std::uint8_t>(1u << (i % chunk_springs));
    } else {
      ++segment.dead;
    }
  }
  if (segment.access != Access::chunks) {
    for (const UnitSpring* spring : slots_) {
      if (spring == nullptr) spring = slots_.front();
      unit_->first.push_back(spring->own);
      unit_->second.push_back(spring->other);
    }
  }
  if (segment.row != mixed_rows) return;
  const Group& group = groups_[segment.group];
  const bool all = std::any_of(slots_.begin(), slots_.end(), [&](const UnitSpring* spring) {
    return spring != nullptr && spring->row >= group.first_rows;
  });
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    if (!all && group.differs[c] == 0) continue;
    ++segment.value_columns;
    for (const UnitSpring* const spring : slots_)
      unit_->values.push_back(spring != nullptr ? group.columns[c][spring->row] : 0.0);
  }
  unit_->settle_values(unit_->segments.size() - 1);
}

void UnitBuilder::add_chunks(const Set& set) {
  bool is_open = false;
  for (std::size_t p = set.piece_begin; p < set.piece_end; ++p) {
    const Piece& piece = pieces_[p];
    if (!is_chunk(piece)) continue;
    if (is_open && slots_.size() == most_chunk_slots_) {
      end_segment();
      is_open = false;
    }
    if (!is_open) begin_segment(springs_[piece.begin], set.row, Access::chunks);
    is_open = true;
    add_to_run(piece);
    std::size_t next = piece.begin;
    for (std::uint32_t i = 0; i < chunk_springs; ++i) {
      const bool has_spring = next < piece.end && springs_[next].own == piece.first + i;
      slots_.push_back(has_spring ? &springs_[next] : nullptr);
      next += has_spring ? 1 : 0;
    }
  }
  if (is_open) end_segment();
}

// A chunk for it, in the run of the one before if it continues that.
void UnitBuilder::add_to_run(const Piece& piece) {
  if (!runs_.empty()) {
    Chunk& before = unit_->chunks.own().back();
    if (piece.first == before.first + chunk_springs && piece.second == before.second + chunk_springs)
      before.is_last = false;
    else
      next_place_ += chunk_springs;  // zeros
  }
  if (runs_.empty() || unit_->chunks.back().is_last)
    runs_.push_back({piece.first, piece.second, next_place_, springs_[piece.begin].own, 0});
  runs_.back().own_last = springs_[piece.end - 1].own;
  unit_->chunks.push_back({piece.first, piece.second, next_place_, true});
  next_place_ += chunk_springs;
}

void UnitBuilder::add_readings(const Run& run, bool is_second) {
  // Of nodes of the unit: its first chunk, its first and last spring.
  const std::uint32_t shift = (is_second ? run.second - run.first : 0) - unit_->first_node;
  const std::uint32_t begin = run.own_begin + shift, end = run.own_last + shift + 1;
  for (std::uint32_t node = begin / chunk_springs * chunk_springs; node < end; node += chunk_springs)
    readings_.push_back({node, is_second, run.place + node - (run.first + shift)});
}

void UnitBuilder::add_sums(Tile& tile) {
  tile.sum_begin = static_cast<std::uint32_t>(unit_->sums.size());
  tile.place_begin = static_cast<std::uint32_t>(unit_->places.size());
  readings_.clear();
  for (const Run& run : runs_)
    for (const bool is_second : {false, true}) add_readings(run, is_second);
  std::sort(readings_.begin(), readings_.end(), [](const Reading& a, const Reading& b) {
    return std::tuple(a.node, a.is_second, a.place) < std::tuple(b.node, b.is_second, b.place);
  });
  for (std::size_t begin = 0; begin < readings_.size();) {
    NodeSum sum{readings_[begin].node, 0, 0};
    for (; begin < readings_.size() && readings_[begin].node == sum.node; ++begin) {
      ++(readings_[begin].is_second ? sum.second_ends : sum.first_ends);
      unit_->places.push_back(readings_[begin].place);
    }
    unit_->sums.push_back(sum);
  }
  tile.sum_end = static_cast<std::uint32_t>(unit_->sums.size());
  unit_->forces = std::max(unit_->forces, next_place_ + chunk_springs);
}

// Springs in no chunk, by their ends. The first ones of all nodes come before the second ones, and so on: an end is not
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
    if (!is_chunk(pieces_[p])) take(pieces_[p].begin, pieces_[p].end);
  std::sort(listed_.begin(), listed_.end(), [](const UnitSpring& s, const UnitSpring& t) {
    return std::tuple(s.own, s.other, s.spring) < std::tuple(t.own, t.other, t.spring);
  });
  rounds_.clear();
  for (std::uint32_t round = 0; rounds_.size() < listed_.size(); ++round) {
    for (std::size_t begin = 0; begin < listed_.size();) {
      std::size_t end = begin + 1;
      while (end < listed_.size() && listed_[end].own == listed_[begin].own) ++end;
      if (begin + round < end) rounds_.push_back(&listed_[begin + round]);
      begin = end;
    }
  }
  for (std::size_t begin = 0; begin < rounds_.size(); begin += max_segment) {
    const std::size_t end = std::min(rounds_.size(), begin + max_segment);
    begin_segment(*rounds_[begin], set.row, is_far ? Access::far : Access::near);
    slots_.assign(rounds_.begin() + static_cast<std::ptrdiff_t>(begin),
                  rounds_.begin() + static_cast<std::ptrdiff_t>(end));
    end_segment();
  }
}

}  // namespace springnet::layers
