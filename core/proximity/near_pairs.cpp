#include "proximity/near_pairs.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "proximity/in_parts.hpp"
#include "proximity/pair_search.hpp"

namespace springnet::proximity {

namespace {

constexpr std::size_t pairs_in_part = 1024;  // of which threads take one after the other

}  // namespace

void find_near(const Primitives& primitives, const PairLists& pairs, const Positions& x, double gap,
               std::vector<NearPair>& found, unsigned threads) {
  found.clear();
  for (const PairKind kind : pair_kinds) {
    const auto find = [&, kind](std::size_t begin, std::size_t end, std::vector<NearPair>& near) {
      for (std::size_t i = begin; i < end; ++i) {
        const Pair pair = pairs[kind][i];
        const auto corners = primitives.corners(kind, pair, x);
        const double thickness = primitives.thickness(kind, pair), reach = thickness + gap;
        if (reach < 0.0 || is_surely_beyond(kind, corners, reach)) continue;
        const Separation now = separation(kind, corners);
        if (now.distance - thickness <= gap) near.push_back({kind, pair, now.distance - thickness, now});
      }
    };
    append_in_parts(pairs[kind].size(), pairs_in_part, threads, found, find);
  }
}

void find_meetings(const Primitives& primitives, const PairLists& pairs, const Positions& start, const Positions& end,
                   std::vector<MeetingPair>& found, unsigned threads) {
  found.clear();
  for (const PairKind kind : pair_kinds) {
    const auto find = [&, kind](std::size_t first, std::size_t last, std::vector<MeetingPair>& meetings) {
      for (std::size_t i = first; i < last; ++i) {
        const Pair pair = pairs[kind][i];
        if (const auto met = first_meeting(kind, primitives.corners(kind, pair, start),
                                           primitives.corners(kind, pair, end), primitives.thickness(kind, pair)))
          meetings.push_back({kind, pair, *met});
      }
    };
    append_in_parts(pairs[kind].size(), pairs_in_part, threads, found, find);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const MeetingPair& a, const MeetingPair& b) { return a.meeting.time < b.meeting.time; });
}

std::vector<NearPair> deepest_overlaps(const Primitives& primitives, const Positions& x, std::size_t most) {
  PairLists pairs;
  PairSearch(primitives).find(x, 0.0, pairs);
  std::vector<NearPair> found;
  find_near(primitives, pairs, x, 0.0, found);
  std::erase_if(found, [](const NearPair& near) { return !(near.gap < 0.0); });
  std::stable_sort(found.begin(), found.end(), [](const NearPair& a, const NearPair& b) { return a.gap < b.gap; });
  if (found.size() > most) found.resize(most);
  return found;
}

}  // namespace springnet::proximity
