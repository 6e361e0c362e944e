// Pairs of bodies at borders of faces and edges: which of those at the same place is settled, for all of them.

#include <algorithm>
#include <bit>
#include <map>
#include <utility>
#include <vector>

#include "constraints/pair_features.hpp"
#include "simulation/pair_events.hpp"
#include "simulation/settling.hpp"

namespace springnet {

void Settling::find_features() {
  for (Candidate& each : candidates_) {
    PairTouch& touch = each.touch;
    if (touch.between == 0 || each.found.at_border)
      touch.between = features_towards(model_.constraints.bodies(), touch, read_only(state_.view.position),
                                       read_only(state_.view.velocity), model_.node_count());
    each.motion = motion_of(each);
  }
}

// Faces on both sides of a groove give way to what they share.
void Settling::join_grooves() {
  const BodyContacts& bodies = model_.constraints.bodies();
  const proximity::Positions x = positions_of(read_only(state_.view.position), model_.node_count());
  std::map<std::uint32_t, std::vector<std::size_t>> of_balls;
  for (std::size_t i = 0; i < candidates_.size(); ++i)
    if (candidates_[i].touch.kind == proximity::PairKind::node_triangle)
      of_balls[candidates_[i].touch.pair.first].push_back(i);
  std::vector<std::uint8_t> joined(candidates_.size(), 0);
  for (const auto& [ball, places] : of_balls)
    for (std::size_t a = 0; a < places.size(); ++a)
      for (std::size_t b = a + 1; b < places.size(); ++b) {
        std::size_t stays = places[a], goes = places[b];
        if (joined[stays] != 0 || joined[goes] != 0) continue;
        if (!candidates_[stays].was && candidates_[goes].was) std::swap(stays, goes);
        const proximity::Features features =
            groove_between(bodies, candidates_[stays].touch.pair, candidates_[goes].touch.pair, x, 0.5 * depth_);
        if (features == 0) continue;
        Candidate& kept = candidates_[stays];
        if (kept.touch.between != features && kept.was) {
          kept.takes_over = true;
          model_.changed();
        }
        kept.touch.between = features;
        kept.motion = motion_of(kept);
        joined[goes] = 1;
        if (candidates_[goes].was) take_over(kept, candidates_[goes]);
      }
  std::vector<Candidate> stay;
  for (std::size_t i = 0; i < candidates_.size(); ++i)
    if (joined[i] == 0) stay.push_back(candidates_[i]);
  candidates_ = std::move(stay);
}

void Settling::leave_out_said() {
  const BodyContacts& bodies = model_.constraints.bodies();
  const proximity::Positions x = positions_of(read_only(state_.view.position), model_.node_count());
  const auto ends_of = [&](const Candidate& each) {
    SideBySide ends;
    if (each.touch.between != proximity::all_features(proximity::PairKind::edge_edge)) return ends;
    const std::array<Vector3, 4> corners = bodies.primitives().corners(each.touch.kind, each.touch.pair, x);
    return before_side_by_side(each.touch.kind, corners, 0.5 * depth_) <= 0.0 ? side_by_side(each.touch.kind, corners)
                                                                              : ends;
  };
  // Those within their faces and edges first, then those that touch already. Last those of which only ends count.
  std::map<std::pair<proximity::PairKind, proximity::Pair>, SideBySide> side_by_sides;
  for (const Candidate& each : candidates_)
    if (const SideBySide ends = ends_of(each); ends.count > 0) side_by_sides.emplace(each.touch.key(), ends);
  std::sort(candidates_.begin(), candidates_.end(), [&](const Candidate& a, const Candidate& b) {
    const bool by_ends_a = side_by_sides.contains(a.touch.key()), by_ends_b = side_by_sides.contains(b.touch.key());
    if (by_ends_a != by_ends_b) return by_ends_b;
    const int of_a = std::popcount(a.touch.between), of_b = std::popcount(b.touch.between);
    if (of_a != of_b) return of_a > of_b;
    if (a.was != b.was) return a.was;
    return a.touch.key() < b.touch.key();
  });
  std::vector<Candidate> stay;
  std::map<std::pair<proximity::PairKind, proximity::Pair>, std::size_t> places;
  std::map<std::uint32_t, std::vector<std::size_t>> at_nodes;  // of those that stay
  const auto is_inside = [](const Candidate& each) {
    return each.touch.between == proximity::all_features(each.touch.kind);
  };
  const auto find_same = [&](const Candidate& each, std::size_t& by) {
    if (!is_inside(each)) return false;
    for (std::size_t i = 0; i < each.motion.count; ++i)
      for (const std::size_t place : at_nodes[each.motion.nodes[i]]) {
        const Candidate& other = stay[place];
        if (!is_inside(other) ||
            !bodies.touch_alike(each.touch.kind, each.touch.pair, other.touch.kind, other.touch.pair) ||
            gradient_difference(each.motion, other.motion) >
                (each.was && other.was ? 2.0 * same_of_touching : nearly_same) ||
            std::abs(each.motion.gap - other.motion.gap) > uncertainty())
          continue;
        by = place;
        return true;
      }
    return false;
  };
  for (const Candidate& each : candidates_) {
    std::size_t by = 0;
    const PairTouch& touch = each.touch;
    const auto is_said_at = [&](proximity::Features features) {
      return is_said_by_another(bodies, touch.kind, touch.pair, features, x,
                                [&](proximity::PairKind kind, proximity::Pair pair) {
                                  const auto found = places.find({kind, pair});
                                  if (found == places.end()) return false;
                                  by = found->second;
                                  return true;
                                });
    };
    const auto ends = side_by_sides.find(touch.key());
    const bool is_said =
        ends == side_by_sides.end()
            ? is_said_at(touch.between) || find_same(each, by)
            : std::all_of(ends->second.ends.begin(), ends->second.ends.begin() + ends->second.count, is_said_at);
    if (!is_said) {
      for (std::size_t i = 0; i < each.motion.count; ++i) at_nodes[each.motion.nodes[i]].push_back(stay.size());
      places[touch.key()] = stay.size();
      stay.push_back(each);
    } else if (each.was) {
      take_over(stay[by], each);
    }
  }
  candidates_ = std::move(stay);
  std::sort(candidates_.begin(), candidates_.end(),
            [](const Candidate& a, const Candidate& b) { return a.touch.key() < b.touch.key(); });
}

void Settling::take_over(Candidate& pair, const Candidate& from) {
  const auto record = [&](Event::Kind kind, const Candidate& of) {
    record_pair(model_, kind, time_, of.motion, read_only(state_.view.position),
                first_velocity(of.motion, read_only(state_.view.velocity)), Vector3::Zero());
  };
  record(Event::Kind::parted, from);
  pair.takes_over = true;
  model_.changed();
  if (pair.was) return;
  pair.was = pair.stays = true;
  record(Event::Kind::met, pair);
  const double sign = pair.motion.normal.dot(from.motion.normal) < 0.0 ? -1.0 : 1.0;
  pair.found = from.found;
  pair.touch.force = sign * from.touch.force;
  pair.touch.guess = sign * from.touch.guess;
  pair.touch.slip = sign * from.touch.slip;
  pair.touch.sticks = from.touch.sticks;
  pair.touch.phase = from.touch.phase;
  pair.touch.held_gap = from.touch.held_gap;
}

}  // namespace springnet
