// The pairs of primitives that may touch within the next steps. The search runs with a *skin*: it finds all pairs
// within their thickness plus the skin, and holds as long as no two nodes have moved towards each other by more than
// that (L. Verlet, 1967). What all nodes have in common does not count, so that a body in free fall keeps its list.
//
// A step asks once: update(start, end) searches anew where needed. A skin of 20 to 50 times the distance that nodes
// move in a step, if this is below the distance of neighbours, makes searches rare and the list short. Any skin is
// correct: where a step goes farther, the search covers the motion of that step itself.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "proximity/pair_schedule.hpp"
#include "proximity/pair_search.hpp"
#include "proximity/primitives.hpp"

namespace springnet::proximity {

class NeighbourList {
 public:
  // skin: m, > 0. Throws Error (input) if it is not.
  NeighbourList(Primitives primitives, double skin, const SearchOptions& options = {});
  // The search refers to the primitives.
  NeighbourList(const NeighbourList&) = delete;
  NeighbourList& operator=(const NeighbourList&) = delete;

  [[nodiscard]] const Primitives& primitives() const noexcept { return primitives_; }
  [[nodiscard]] double skin() const noexcept { return skin_; }

  // After this, pairs() has every pair whose distance falls to its thickness while nodes move along straight lines from
  // `start` to `end`; or along lines that bend away from these by at most half of `bend` (m, below the skin). Returns
  // whether it had to search. Throws as PairSearch::find; the list is empty then, and the next call searches.
  bool update(const Positions& start, const Positions& end, double bend = 0.0);
  bool update(const Positions& x) { return update(x, x); }
  // pairs() holds at these positions: no two nodes have approached by more than the skin, less `margin` (m), since the
  // search. False if a coordinate is not finite.
  [[nodiscard]] bool covers(const Positions& x, double margin = 0.0) const;
  // Searches at the next update.
  void forget() noexcept { is_valid_ = false; }

  // In canonical order; they depend on the positions of the last search.
  [[nodiscard]] const PairLists& pairs() const noexcept { return pairs_; }
  // In the same order, those of pairs() whose gap may be `gap` (m, >= 0) or less at some time between the positions of
  // the last update. Pairs far apart are looked at only when their nodes have moved by what they were apart.
  [[nodiscard]] const PairLists& close(double gap);
  [[nodiscard]] std::size_t searches() const noexcept { return searches_; }

 private:
  // m: a bound of how far any two nodes have moved relative to each other since the search. Infinite if a coordinate is
  // not finite.
  [[nodiscard]] double relative_motion(const Positions& x) const;
  void note_motion(const Positions& start, const Positions& end);

  Primitives primitives_;
  double skin_;  // m
  PairSearch search_;
  PairLists pairs_;
  bool is_valid_ = false;
  std::size_t searches_ = 0;
  std::array<std::vector<double>, 3> reference_;  // m, [primitives_.nodes()]: positions for which the search was

  PairSchedule schedule_;
  PairLists close_;
  double close_within_ = 0.0;  // m, gap of the present close_; less than 0: none
  // m, bounds of relative motions: between the starts of the last two updates or more, within the last one, and from
  // the search to its start.
  double moved_ = 0.0, step_ = 0.0, from_search_ = 0.0;
  std::array<std::vector<double>, 3> start_;  // m, [node], of the last update
};

}  // namespace springnet::proximity
