#include "simulation/impact_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "constraints/path_minimum.hpp"

namespace springnet {
namespace {

// In parts this short the path is taken as the cubic through its ends: its error is 256^-4 of that over the step.
constexpr double shortest_part = 1.0 / 256.0;
constexpr double tenth_of_turn = 0.6;  // rad
// A node deeper than this share of the obstacle's inscribed radius is inside, however uncertain positions are.
constexpr double share_of_inside = 0.25;

}  // namespace

ImpactSearch::ImpactSearch(const Model& model, const std::vector<ContactEvents::Source>& sources,
                           const springnet_impact_search& search)
    : model_(model), search_(search) {
  for (const ContactEvents::Source& source : sources)
    if (source.kind == ContactEvents::Source::Kind::touch)
      pairs_.push_back({source.index, source.surface, source.offset});
  if (pairs_.empty()) return;
  const double length = search.step_until - search.step_from;
  for (const Obstacle& surface : model.contact.obstacles())
    longest_.push_back(surface.angular_frequency(search.step_from));
  // A table may turn an obstacle all the way round between two rests.
  for (const double share : {0.0, 0.5, 1.0}) {
    const std::shared_ptr<const Placement> at = model.placement(search.step_from + share * length);
    for (std::size_t j = 0; j < longest_.size(); ++j)
      if (!model.contact.obstacles()[j].turns_in_place()) longest_[j] = std::max(longest_[j], at->poses[j].spin.norm());
  }
  for (double& each : longest_) each = each > 0.0 ? std::min(length, tenth_of_turn / each) : length;
}

bool ImpactSearch::evaluate(double time, Snapshot& snapshot) {
  if (status_ != SPRINGNET_OK) return false;
  const std::size_t n = model_.layout.node_count();
  snapshot.time = time;
  snapshot.at = model_.placement(time);
  snapshot.values.resize(6 * n);
  double* const x = snapshot.values.data();
  const springnet_dense_output output{sizeof output, 0, time, {x, x + n, x + 2 * n}, {x + 3 * n, x + 4 * n, x + 5 * n}};
  status_ = search_.state_at(search_.user, &output);
  return status_ == SPRINGNET_OK;
}

ImpactSearch::NodeState ImpactSearch::node_state(const Snapshot& snapshot, const Pair& pair) const {
  const std::size_t n = model_.layout.node_count();
  const double* const x = snapshot.values.data() + pair.node;
  const Vector3 position(x[0], x[n], x[2 * n]);
  return {position, {x[3 * n], x[4 * n], x[5 * n]}, model_.contact.gap(*snapshot.at, pair.surface, position)};
}

ImpactSearch::Instant ImpactSearch::instant(const Snapshot& snapshot, const std::vector<Pair>& pairs) const {
  Instant result{snapshot.time, snapshot.at, {}};
  result.states.reserve(pairs.size());
  for (const Pair& pair : pairs) result.states.push_back(node_state(snapshot, pair));
  return result;
}

bool ImpactSearch::may_reach(const Instant& from, const Instant& until, const Pair& pair, const NodeState& a,
                             const NodeState& b) const {
  const double h = until.time - from.time;
  const Vector3 path = b.position - a.position;
  const double travel = path.norm() + bend_of((h * a.velocity - path).norm(), (h * b.velocity - path).norm());
  const Obstacle& surface = model_.contact.obstacles()[pair.surface];
  return surface.min_gap(from.at->poses[pair.surface], a.position) + pair.depth <= travel;
}

// In the frame of the obstacle, where the gap changes by no more than the position. In a short part the path is taken
// as the cubic.
bool ImpactSearch::comes_near(const Instant& from, const Instant& until, const Pair& pair, const NodeState& a,
                              const NodeState& b, bool short_part) const {
  const double before = a.gap + pair.depth, after = b.gap + pair.depth;
  if (before <= 0.0) return false;  // it is inside already
  if (after <= 0.0) return true;
  const Obstacle& surface = model_.contact.obstacles()[pair.surface];
  const auto pose_of = [&](const Instant& instant) {
    Pose pose = instant.at->poses[pair.surface];
    pose.turns = pose.turns && !surface.turns_in_place();
    return pose;
  };
  const Pose first = pose_of(from), last = pose_of(until);
  const auto seen = [](const Pose& pose, const Vector3& relative) {
    return pose.turns ? Vector3(pose.rotation.transpose() * relative) : relative;
  };
  const double h = until.time - from.time;
  const Vector3 start = first.to_start(a.position), path = last.to_start(b.position) - start;
  const Vector3 bent0 = h * seen(first, a.velocity - first.velocity_at(a.position)) - path;
  const Vector3 bent1 = h * seen(last, b.velocity - last.velocity_at(b.position)) - path;
  const bool flat = surface.is_flat();
  const Vector3 n = flat ? seen(first, surface.normal(first, a.position)) : Vector3(Vector3::Zero());
  const auto towards = [&](const Vector3& v) { return flat ? std::abs(n.dot(v)) : v.norm(); };
  const double bend = bend_of(towards(bent0), towards(bent1));
  if (before + after - towards(path) > 2.0 * bend) return false;
  double least = std::min(before, after);
  if (!flat || short_part) {
    constexpr int turns = 30;  // to 5e-7 of the path, and the square of that in the gap
    const auto gap = [&](double s) {
      Vector3 place = start + s * path;
      if (short_part) place += s * (1.0 - s) * ((1.0 - s) * bent0 - s * bent1);
      return surface.gap(first, first.from_start(place)) + pair.depth;
    };
    least = std::min(least, minimum_on_path(gap, -std::numeric_limits<double>::infinity(), turns).value);
  }
  return least <= (short_part ? 0.0 : bend);
}

std::optional<double> ImpactSearch::first(const Instant& from, const Instant& until, const std::vector<Pair>& pairs,
                                          const Part& part) {
  const double length = until.time - from.time;
  if (until.time <= part.earliest || from.time >= part.latest) return std::nullopt;
  std::vector<Pair> near;
  Instant begin{from.time, from.at, {}}, end{until.time, until.at, {}};
  bool crosses = false;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Pair& pair = pairs[i];
    const NodeState &a = from.states[i], &b = until.states[i];
    const double longest = longest_[pair.surface];
    if (length > longest ? !may_reach(from, until, pair, a, b)
                         : !comes_near(from, until, pair, a, b, length < shortest_part * longest))
      continue;
    near.push_back(pair);
    begin.states.push_back(a);
    end.states.push_back(b);
    crosses = crosses || (a.gap + pair.depth > 0.0 && b.gap + pair.depth <= 0.0);
  }
  if (near.empty()) return std::nullopt;
  const double size = std::max(std::abs(until.time), search_.step_until - search_.step_from);
  if (length <= roundings * std::numeric_limits<double>::epsilon() * size)
    return crosses ? std::optional(until.time) : std::nullopt;
  if (!evaluate(from.time + 0.5 * length, between_)) return std::nullopt;
  const Instant middle = instant(between_, near);
  const std::optional<double> early = first(begin, middle, near, part);
  return early ? early : first(middle, end, near, part);
}

// First finds the time at which a node is deep enough, then the time at which it entered.
springnet_status ImpactSearch::find(double& time) {
  time = std::numeric_limits<double>::quiet_NaN();
  if (pairs_.empty()) return SPRINGNET_OK;
  std::vector<Pair> deep = pairs_;
  for (Pair& pair : deep)
    pair.depth +=
        std::min(search_.depth, share_of_inside * model_.contact.obstacles()[pair.surface].inscribed_radius());
  if (!evaluate(search_.step_from, between_)) return status_;
  const Instant start = instant(between_, pairs_);
  if (!evaluate(search_.step_until, between_)) return status_;
  const std::optional<double> inside = first(start, instant(between_, pairs_), deep, {search_.from, search_.until});
  if (!inside || !evaluate(*inside, between_)) return status_;
  const Instant then = instant(between_, pairs_);
  std::vector<Pair> entered;
  Instant begin{start.time, start.at, {}}, end{then.time, then.at, {}};
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (then.states[i].gap + deep[i].depth > 0.0) continue;
    entered.push_back(pairs_[i]);
    begin.states.push_back(start.states[i]);
    end.states.push_back(then.states[i]);
  }
  // No earlier than the start of the searched part: earlier searches found no node deep enough.
  const std::optional<double> begins = first(begin, end, entered, {search_.step_from, *inside});
  if (status_ == SPRINGNET_OK) time = std::max(search_.from, begins.value_or(*inside));
  return status_;
}

}  // namespace springnet
