// From pairs that may touch to those that do: at one state, over a step, and at the start of a simulation. In a step:
//   list.update(start, end);                                             // a check; a search where needed
//   find_near(list.primitives(), list.pairs(), end, 0.0, near);          // contact forces: gap, direction, weights
//   find_meetings(list.primitives(), list.pairs(), start, end, met);     // the earliest of what must not go through
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "proximity/distance.hpp"
#include "proximity/first_meeting.hpp"
#include "proximity/primitives.hpp"

namespace springnet::proximity {

struct NearPair {
  PairKind kind;
  Pair pair;
  double gap;  // m: distance less thickness; < 0 where they overlap
  Separation separation;
};

// Pairs of the lists whose gap is at most `gap` (m), in the order of the lists, for any number of threads.
// `found` keeps its memory.
void find_near(const Primitives& primitives, const PairLists& pairs, const Positions& x, double gap,
               std::vector<NearPair>& found, unsigned threads = 1);

struct MeetingPair {
  PairKind kind;
  Pair pair;
  Meeting meeting;
};

// Pairs of the lists that meet while nodes move along straight lines, in the order of time, then of the lists.
void find_meetings(const Primitives& primitives, const PairLists& pairs, const Positions& start, const Positions& end,
                   std::vector<MeetingPair>& found, unsigned threads = 1);

// Pairs that overlap at these positions, the deepest first, `most` at most: what a net should not start with. Throws as
// PairSearch::find.
[[nodiscard]] std::vector<NearPair> deepest_overlaps(const Primitives& primitives, const Positions& x,
                                                     std::size_t most);

}  // namespace springnet::proximity
