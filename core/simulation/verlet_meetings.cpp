// Which pairs of bodies meet on the ways of a step, and which of these impacts are next.
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "simulation/verlet_pairs.hpp"

namespace springnet {
namespace {

constexpr double share_of_there = 2e-4;  // of the thickness: so near the search for meetings takes a pair for touching
constexpr std::size_t most_in_order = 16;  // times of impacts near each other; of more, the first of each node

// When and how a pair comes to its thickness, from a meeting that may be a little early: Newton's method on the
// distance along the paths. Empty if it only comes near.
std::optional<proximity::Meeting> refine(proximity::PairKind kind, const std::array<Vector3, 4>& start,
                                         const std::array<Vector3, 4>& end, double thickness,
                                         proximity::Meeting found) {
  constexpr int most = 40;  // of grazing pairs, each has a quarter of the gap before
  const Vector3 side = found.at.direction;
  for (int i = 0; i < most; ++i) {
    double rate = 0.0;  // of the distance, over the step
    for (std::size_t k = 0; k < 4; ++k) rate += found.at.weights[k] * found.at.direction.dot(end[k] - start[k]);
    const double gap = found.at.distance - thickness;
    if (!(gap > 0.0)) break;
    const double time = rate < 0.0 ? found.time - gap / rate : 2.0;
    if (!(time > found.time)) break;
    if (time > 1.0) {
      // Distances of straight motions are convex, so that it does not get there; pairs that turn may.
      if (on_side(separation(kind, end), side).distance >= thickness) return std::nullopt;
      break;
    }
    std::array<Vector3, 4> now;
    for (std::size_t k = 0; k < 4; ++k) now[k] = start[k] + time * (end[k] - start[k]);
    found.at = on_side(separation(kind, now), found.at.direction);
    found.time = time;
  }
  return found;
}

}  // namespace

void VerletPairs::add_first(const springnet_sweep& step, const proximity::Positions& start,
                            const proximity::Positions& end) {
  const proximity::Primitives& all = model_.constraints.bodies().primitives();
  struct Found {
    proximity::PairKind kind;
    proximity::Pair pair;
    proximity::Meeting at;
  };
  std::vector<Found> found;
  // Before an impact of one of its nodes the path of a pair is another one.
  struct Way {
    double since;  // share of the step
    std::array<Vector3, 4> from, to;
  };
  const auto way_of = [&](proximity::PairKind kind, proximity::Pair pair) {
    Way way{0.0, all.corners(kind, pair, start), all.corners(kind, pair, end)};
    for (const std::uint32_t node : all.nodes_of(kind, pair))
      if (const auto struck = struck_.find(node); struck != struck_.end())
        way.since = std::max(way.since, struck->second);
    for (std::size_t k = 0; k < 4; ++k) way.from[k] += way.since * (way.to[k] - way.from[k]);
    return way;
  };
  // early: in units of its way.
  const auto look_at = [&](proximity::PairKind kind, proximity::Pair pair, const Way& way,
                           const std::optional<proximity::Meeting>& early) {
    auto meeting = refine(kind, way.from, way.to, all.thickness(kind, pair),
                          early ? *early : proximity::Meeting{0.0, separation(kind, way.from)});
    if (!meeting) return;
    meeting->time = way.since + (1.0 - way.since) * meeting->time;
    found.push_back({kind, pair, *meeting});
  };
  for (const proximity::MeetingPair& each : met_) {
    if (known_.contains(std::pair(each.kind, each.pair))) continue;
    const Way way = way_of(each.kind, each.pair);
    if (way.since == 0.0 && each.meeting.from_start) {
      add(step, each.kind, each.pair, separation(each.kind, way.from), 0.0, false);
      continue;
    }
    const double thickness = all.thickness(each.kind, each.pair);
    const proximity::Separation there = separation(each.kind, way.from);
    if (there.distance > (1.0 + share_of_there) * thickness) {
      const auto meeting =
          way.since > 0.0 ? first_meeting(each.kind, way.from, way.to, thickness) : std::optional(each.meeting);
      if (meeting) look_at(each.kind, each.pair, way, meeting);
      continue;
    }
    // It was watched against half of its distance.
    double rate = 0.0;
    for (std::size_t k = 0; k < 4; ++k) rate += there.weights[k] * there.direction.dot(way.to[k] - way.from[k]);
    if (rate < 0.0) look_at(each.kind, each.pair, way, std::nullopt);
  }
  // What begins so near that it counts as touching.
  std::set<std::pair<proximity::PairKind, proximity::Pair>> met;
  for (const Found& each : found) met.emplace(each.kind, each.pair);
  for (const proximity::NearPair& each : near_) {
    const std::pair key(each.kind, each.pair);
    if (each.gap >= -tolerance_.gap || known_.contains(key) || met.contains(key)) continue;
    look_at(each.kind, each.pair, way_of(each.kind, each.pair), std::nullopt);
  }
  // Of each node, and of each cluster, the first one: its path after that is another one.
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) {
    return std::tuple(a.at.time, a.kind, a.pair) < std::tuple(b.at.time, b.kind, b.pair);
  });
  std::map<std::uint32_t, double> taken;
  std::vector<const Found*> first;
  for (const Found& each : found) {
    const std::array<std::uint32_t, 4> nodes = all.nodes_of(each.kind, each.pair);
    const bool is_later = std::any_of(nodes.begin(), nodes.end(), [&](std::uint32_t node) {
      const auto before = taken.find(node);
      return before != taken.end() && each.at.time > before->second + simultaneous;
    });
    for (const std::uint32_t node : nodes)
      if (mobility_[node] > 0.0)
        clusters_.for_each_moved(node, [&](std::uint32_t k) { taken.emplace(k, each.at.time); });
    if (!is_later) first.push_back(&each);
  }
  std::vector<MeetingNodes> meetings;
  for (const Found* each : first) meetings.push_back({all.nodes_of(each->kind, each->pair), each->at.time});
  const std::vector<std::uint8_t> due = in_order(meetings);
  std::size_t place = 0;
  std::erase_if(first, [&](const Found*) { return due[place++] == 0; });
  bool struck = false;
  for (const Found* each : first) struck = strike(step, each->kind, each->pair, each->at.time) || struck;
  if (struck) renew_mobility(step);
  for (const Found* each : first) add(step, each->kind, each->pair, each->at.at, each->at.time, true);
}

// What is struck may meet others before they meet what comes later: of all that are near each other, by way of others
// that move, too, only the first are due.
std::vector<std::uint8_t> VerletPairs::in_order(const std::vector<MeetingNodes>& meetings) const {
  std::vector<std::uint8_t> due(meetings.size(), 1);
  if (meetings.empty() || !(meetings.back().time > meetings.front().time + simultaneous)) return due;
  // Sets of nodes, each with one that stands for it; the nodes of a cluster move together.
  std::vector<std::uint32_t> parent(model_.node_count() + model_.rigid.cluster_count());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto set_of = [&](std::uint32_t node) {
    std::uint32_t k = model_.rigid.is_joined(node)
                          ? static_cast<std::uint32_t>(model_.node_count() + model_.rigid.cluster_of()[node])
                          : node;
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  };
  constexpr std::uint32_t none = UINT32_MAX;
  // That of the nodes of a pair which can move.
  const auto join = [&](const std::array<std::uint32_t, 4>& nodes) {
    std::uint32_t all = none;
    for (const std::uint32_t node : nodes)
      if (mobility_[node] > 0.0) {
        const std::uint32_t k = set_of(node);
        if (all == none) all = k;
        parent[k] = all;
      }
    return all;
  };
  BodyContacts& bodies = model_.constraints.bodies();
  for (const proximity::PairKind kind : proximity::pair_kinds)
    for (const proximity::Pair& pair : bodies.list().close(0.0)[kind])
      static_cast<void>(join(bodies.primitives().nodes_of(kind, pair)));
  struct Times {
    double first;
    double last;  // of those that are counted
    std::size_t count = 1;
  };
  std::map<std::uint32_t, Times> of_set;
  const auto set_of_meeting = [&](const MeetingNodes& each) { return join(each.nodes); };
  for (const MeetingNodes& each : meetings) {
    const auto [known, is_new] = of_set.try_emplace(set_of_meeting(each), Times{each.time, each.time});
    if (is_new || !(each.time > known->second.last + simultaneous)) continue;
    known->second.last = each.time;
    ++known->second.count;
  }
  for (std::size_t i = 0; i < meetings.size(); ++i) {
    const Times& times = of_set.at(set_of_meeting(meetings[i]));
    if (times.count <= most_in_order && meetings[i].time > times.first + simultaneous) due[i] = 0;
  }
  return due;
}

}  // namespace springnet
