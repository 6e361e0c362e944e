// A unit of the layout: a range of nodes, tiles of them, segments of a tile's springs with the same laws.
//
// A spring between two nodes of a unit belongs to the tile of its lower node, so that the forces on a tile are final
// once it has been evaluated. A spring to the next unit belongs to the lower node, too: the forces on the first nodes
// of that unit, its halo, are summed apart, and added when both units are done. A spring that leads further is in both
// units, and each adds to its own node only. So no two units write to the same place, whichever threads they run on,
// and the order of every sum is fixed by the layout.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "layers/kernels.hpp"
#include "layers/laws.hpp"
#include "layers/shared.hpp"

namespace springnet::layers {

inline constexpr std::uint32_t mixed_rows = 0xffffffffu;

// Springs that are read and written contiguously, through a window, or one by one.
enum class Access : std::uint8_t {
  chunks,
  near,  // by their ends, in the unit or the next one
  far    // by their ends, the second elsewhere: force on the first ends only
};

struct Segment {
  std::uint32_t group;
  std::uint32_t row;            // of all its springs, or mixed_rows
  std::uint32_t begin, count;   // slots in the unit, multiples of chunk_springs
  std::uint32_t place;          // where its chunks, or its ends, begin
  std::uint32_t dead;           // slots without a spring: removed ones, and gaps
  std::uint32_t living;         // a slot with one, counted from `begin`
  std::size_t value_begin;      // its parameters in Unit::values, if rows are mixed
  std::uint32_t value_columns;  // of them: those in which the first rows of its group differ, or all
  Access access;
  bool has_empty_chunk;  // all of whose springs were removed
};

struct Tile {
  std::uint32_t first_node, node_count;
  std::uint32_t segment_begin, segment_end;
  std::uint32_t sum_begin, sum_end;  // of its chunks' forces
  std::uint32_t place_begin;         // of these sums in Unit::places
};

struct Unit {
  std::uint32_t first_node = 0, node_count = 0;
  std::uint32_t halo = 0;    // nodes of the next unit up to the last one that a spring of this one leads to
  std::uint32_t reach = 0;   // most that a second end is ahead of the first node of its tile
  std::uint32_t window = 0;  // places of the window for springs by their ends, a power of 2; 0: there are none
  std::size_t live = 0;      // slots with a spring; when it was laid out:
  std::size_t laid_out = 0;
  std::size_t all = 0;       // springs that it had at first
  std::uint32_t forces = 0;  // most places for forces of chunks that a tile needs
  // Shared by copies, of which a cut changes a few.
  SharedVector<Tile> tiles;
  SharedVector<Segment> segments;
  SharedVector<Chunk> chunks;
  SharedVector<NodeSum> sums;
  SharedVector<std::uint32_t> places;         // of forces, those of each sum after each other
  SharedVector<std::uint32_t> first, second;  // ends of springs that are in no chunk
  SharedVector<std::uint32_t> spring;         // [slot] or no_spring
  SharedVector<std::uint8_t> live_mask;       // [slot / 8] a bit for each slot with a spring
  SharedVector<std::uint32_t> internal;       // [slot] place in the internal state; empty: no spring of the net has any
  SharedVector<double> values;                // of segments of mixed rows, [column][slot] of each segment

  [[nodiscard]] std::uint32_t end_node() const noexcept { return first_node + node_count; }
  [[nodiscard]] SegmentSprings springs_of(const Segment& segment) const noexcept {
    const std::uint8_t* const live_slots = segment.dead == 0 ? nullptr : live_in(segment);
    if (segment.access == Access::chunks)
      return {chunks.data() + segment.place, live_slots, segment.count, nullptr, nullptr};
    return {nullptr, live_slots, segment.count, first.data() + segment.place, second.data() + segment.place};
  }
  // Whether slots without a spring have yet to be given the values of one (Kernels::settle_dead).
  [[nodiscard]] static bool is_unsettled(const Segment& segment) noexcept {
    return segment.access == Access::chunks ? segment.has_empty_chunk : segment.dead > 0;
  }
  // [slot] of a segment.
  [[nodiscard]] const std::uint32_t* internal_of(const Segment& segment) const noexcept {
    return internal.empty() ? nullptr : internal.data() + segment.begin;
  }
  // [slot / 8] of a segment.
  [[nodiscard]] const std::uint8_t* live_in(const Segment& segment) const noexcept {
    return live_mask.data() + segment.begin / chunk_springs;
  }
  // Removes a spring from the tile of its end `own`, which must be in the unit.
  void remove(std::uint32_t own, std::uint32_t spring_number);
  // Gives slots without a spring the parameters and the internal state of the spring whose length they get: of the
  // first one of their chunk, or of `living`. A law could fail for the length of one spring and the rest length of
  // another.
  void settle_values(std::size_t segment);
  // The same where one value of a segment of mixed rows has changed; place: of the slot in the segment.
  void settle_value(std::size_t segment, std::size_t column, std::uint32_t place);
};

// Where the values of the columns of a segment of mixed rows are: RowSelection::columns. A column without any has one
// value for the segment, that of the group's first row.
class SegmentColumns {
 public:
  SegmentColumns(const Unit& unit, const Segment& segment, const Group& group) noexcept;
  [[nodiscard]] const double* const* data() const noexcept { return columns_; }

 private:
  const double* columns_[2 * (max_parameters + max_inputs) + 1];
};

}  // namespace springnet::layers
