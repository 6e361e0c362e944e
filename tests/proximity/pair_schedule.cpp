// Pairs of a list that are looked at when they may be close, beside a look at all of them.
#include "proximity/pair_schedule.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "proximity/near_pairs.hpp"
#include "proximity/neighbour_list.hpp"
#include "random_pairs.hpp"
#include "surfaces.hpp"

using namespace springnet;
using namespace springnet::proximity;

namespace {

Surfaces folds() {
  Surfaces surfaces;
  add_folded_sheet(surfaces, 16, 0.01, 5, 3e-4, Vector3::Zero(), 1e-4, 0);
  return surfaces;
}

Surfaces moved(const Surfaces& from, PairDice& dice, double distance) {
  Surfaces to = from;
  for (NodeIndex node = 0; node < to.x[0].size(); ++node)
    to.set(node, from.positions()[node] + Vector3(0.02, 0, 0) + dice.vector(distance));
  return to;
}

// What find_near() and find_meetings() make of these pairs, with all bits of gaps and times.
struct Found {
  std::vector<std::pair<Pair, double>> near, met;
  bool operator==(const Found&) const = default;
};

Found found_of(const Primitives& primitives, const PairLists& pairs, const Surfaces& start, const Surfaces& end,
               double gap) {
  Found found;
  std::vector<NearPair> near;
  for (const Surfaces* at : {&start, &end}) {
    find_near(primitives, pairs, at->positions(), gap, near);
    for (const NearPair& each : near) found.near.emplace_back(each.pair, each.gap);
  }
  std::vector<MeetingPair> met;
  find_meetings(primitives, pairs, start.positions(), end.positions(), met);
  for (const MeetingPair& each : met) found.met.emplace_back(each.pair, each.meeting.time);
  return found;
}

}  // namespace

TEST_CASE("close pairs are all that come near or meet, whatever the motion") {
  PairDice dice(3);
  Surfaces now = folds();
  const Primitives primitives(now.lists({{0, 0}}));
  NeighbourList list(primitives, 2e-3);
  std::size_t near = 0, met = 0, close = 0, all = 0;
  for (int step = 0; step < 200; ++step) {
    CAPTURE(step);
    // A step of some 1e-8 to 1e-4 m; steps that are tried before the one that is taken; places that it only looks at.
    const double distance = 1e-8 * std::pow(10.0, dice.number(0.0, 4.0));
    for (int tries = 0; tries < 1 + step % 3; ++tries) {
      const Surfaces next = moved(now, dice, distance);
      list.update(now.positions(), next.positions());
      for (const double gap : {0.0, 2e-5, 0.0, 2e-4, 1e-3}) {
        const PairLists& found = list.close(gap);
        const Found expected = found_of(primitives, list.pairs(), now, next, gap);
        CHECK(found_of(primitives, found, now, next, gap) == expected);
        near += expected.near.size();
        met += expected.met.size();
        if (gap == 0.0 && tries == 0) close += found.size();
        if (gap == 0.0 && tries == 0) all += list.pairs().size();
      }
      if (tries == step % 3) now = next;
    }
    if (step % 50 == 7) {
      const Surfaces away = moved(now, dice, 3e-4);
      list.update(away.positions());
      CHECK(found_of(primitives, list.close(0.0), away, away, 0.0) ==
            found_of(primitives, list.pairs(), away, away, 0.0));
    }
    if (step % 100 == 33) list.forget();
  }
  CHECK(near > 300);
  CHECK(met > 3);
  CHECK(close < all / 4);
}

TEST_CASE("a pair far apart is looked at again when its nodes have moved by its gap, not before") {
  // Two balls, 0.5 m apart but for their radii, that approach by 1 mm a step.
  PrimitiveLists lists;
  lists.balls = {{0, 0.1, 0}, {1, 0.1, 1}};
  lists.checked = {{0, 1, true, false, false}};
  const Primitives primitives(lists);
  PairLists pairs;
  pairs[PairKind::node_node] = {{0, 1}};
  PairSchedule schedule;
  schedule.reset(pairs, 4.0);
  std::array<std::vector<double>, 3> x{{{0.0, 0.7}, {0.0, 0.0}, {0.0, 0.0}}};
  const Positions positions{{x[0].data(), x[1].data(), x[2].data()}, 2};
  PairLists close;
  int first = 0;
  for (int step = 1; step <= 520 && first == 0; ++step) {
    x[0][1] = 0.7 - 1e-3 * step;
    // Until it is due its positions do not matter.
    if (step > 1 && step < 490) x[0][1] = std::numeric_limits<double>::quiet_NaN();
    schedule.find_close(primitives, pairs, positions, 1e-3, 1e-3, close);
    if (close.size() > 0) first = step;
  }
  CHECK(first == 499);
}

TEST_CASE("a list goes on after positions that are not finite") {
  PairDice dice(4);
  const Surfaces now = folds();
  const Primitives primitives(now.lists({{0, 0}}));
  NeighbourList list(primitives, 2e-3);
  list.update(now.positions());
  CHECK(list.close(1e-3).size() > 0);
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const bool at_start : {false, true}) {
      Surfaces broken = now;
      broken.x[1][17] = wrong;
      CHECK_THROWS_AS(list.update((at_start ? broken : now).positions(), broken.positions()), Error);
      CHECK(list.close(1e-3).size() == 0);
      const Surfaces next = moved(now, dice, 1e-4);
      list.update(now.positions(), next.positions());
      CHECK(found_of(primitives, list.close(0.0), now, next, 0.0) ==
            found_of(primitives, list.pairs(), now, next, 0.0));
      CHECK(list.close(1e-3).size() > 0);
    }
}
