// Lays out the springs of a unit.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "layers/unit.hpp"

namespace springnet::layers {

// A spring seen from the end by which it belongs to a unit.
struct UnitSpring {
  std::uint32_t own, other;  // nodes
  std::uint32_t spring, group, row;
  bool is_far;
};

class UnitBuilder {
 public:
  // node_count, spring_count: of the whole net.
  UnitBuilder(const std::vector<Group>& groups, std::uint32_t node_count, std::size_t spring_count);
  // Fills in a unit whose range of nodes is set. Reorders `springs`.
  void build(Unit& unit, std::span<UnitSpring> springs);

 private:
  // Springs of equal laws: of one row, or of several.
  struct Set {
    std::size_t begin, end;  // in springs_
    std::uint32_t row;
    std::size_t piece_begin, piece_end;
  };
  // Springs of a chunk.
  struct Piece {
    std::size_t begin, end;
    std::uint32_t first, second;  // of the chunk
  };

  void find_sets(std::size_t begin, std::size_t end);
  void add_set(std::size_t begin, std::size_t end, std::uint32_t row);
  void find_pieces(Set& set);
  [[nodiscard]] bool is_chunk(const Piece& piece) const noexcept;
  void add_sums(Tile& tile);
  void add_chunks(const Set& set);
  void add_listed(const Set& set);
  void begin_segment(const UnitSpring& one, std::uint32_t row, Access access);
  void end_segment();

  const std::vector<Group>& groups_;
  const std::uint32_t node_count_;
  const std::size_t smallest_uniform_, most_chunk_slots_;
  Unit* unit_ = nullptr;
  std::span<UnitSpring> springs_;
  bool all_in_chunks_ = false;
  std::vector<Set> sets_;
  std::vector<Piece> pieces_;
  // Chunks of one distance that follow each other, and their places in memory.
  struct Run {
    std::uint32_t first, second;        // of its first chunk
    std::uint32_t place;                // of its forces
    std::uint32_t own_begin, own_last;  // nodes of its first and its last spring
  };
  void add_to_run(const Piece& piece);
  // What a sum reads: forces on the ends of a run.
  struct Reading {
    std::uint32_t node;
    bool is_second;
    std::uint32_t place;
  };
  void add_readings(const Run& run, bool is_second);

  std::vector<Run> runs_;  // of the tile
  std::uint32_t next_place_ = 0;
  std::vector<Reading> readings_;
  std::vector<UnitSpring> listed_, mixed_, copy_;
  std::vector<const UnitSpring*> rounds_;
  std::vector<const UnitSpring*> slots_;  // of the segment; null: without a spring
};

}  // namespace springnet::layers
