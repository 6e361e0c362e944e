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
  explicit UnitBuilder(const std::vector<Group>& groups) : groups_(groups) {}
  // Fills in a unit whose range of nodes is set. Reorders `springs`.
  void build(Unit& unit, std::span<UnitSpring> springs);

 private:
  // Springs of equal laws: of one row, or of several.
  struct Set {
    std::size_t begin, end;  // in springs_
    std::uint32_t row;
    std::size_t piece_begin, piece_end;
  };
  // Springs whose second ends are as far from their first ends, which follow each other but for small gaps.
  struct Piece {
    std::size_t begin, end;
    std::uint32_t slots;
    bool is_across;
  };

  void find_sets(std::size_t begin, std::size_t end);
  void add_set(std::size_t begin, std::size_t end, std::uint32_t row);
  void find_pieces(Set& set);
  void add_runs(const Set& set, bool is_across);
  void add_listed(const Set& set);
  Segment& begin_segment(const UnitSpring& one, std::uint32_t row, Reach reach);
  void end_segment(std::span<const UnitSpring* const> slots);

  const std::vector<Group>& groups_;
  Unit* unit_ = nullptr;
  std::span<UnitSpring> springs_;
  std::uint32_t shortest_run_ = 0;
  std::vector<Set> sets_;
  std::vector<Piece> pieces_;
  std::vector<UnitSpring> listed_, mixed_;
  std::vector<const UnitSpring*> slots_;
};

}  // namespace springnet::layers
