#include "proximity/near_pairs.hpp"

#include <algorithm>

#include "proximity/pair_search.hpp"

namespace springnet::proximity {

void find_near(const Primitives& primitives, const PairLists& pairs, const Positions& x, double gap,
               std::vector<NearPair>& found) {
  found.clear();
  for (const PairKind kind : pair_kinds)
    for (const Pair& pair : pairs[kind]) {
      const auto corners = primitives.corners(kind, pair, x);
      const double thickness = primitives.thickness(kind, pair), reach = thickness + gap;
      if (reach < 0.0 || is_surely_beyond(kind, corners, reach)) continue;
      const Separation now = separation(kind, corners);
      if (now.distance - thickness <= gap) found.push_back({kind, pair, now.distance - thickness, now});
    }
}

void find_meetings(const Primitives& primitives, const PairLists& pairs, const Positions& start, const Positions& end,
                   std::vector<MeetingPair>& found) {
  found.clear();
  for (const PairKind kind : pair_kinds)
    for (const Pair& pair : pairs[kind])
      if (const auto met = first_meeting(kind, primitives.corners(kind, pair, start),
                                         primitives.corners(kind, pair, end), primitives.thickness(kind, pair)))
        found.push_back({kind, pair, *met});
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
