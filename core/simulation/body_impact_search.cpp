#include "simulation/body_impact_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "constraints/pair_features.hpp"
#include "profile/stage.hpp"
#include "simulation/impact_search.hpp"
#include "simulation/pair_events.hpp"

namespace springnet {
namespace {

// In units of the skin of the list of neighbours: of paths between two times.
constexpr double most_bend = 0.2;
constexpr double shortest_part = 1.0 / 1024.0;  // of the step
// In units of the rounding of the greatest coordinate: distances that differ by less are the same.
constexpr double roundings_of_distance = 16.0;
// In units of the thickness: a pair this deep is inside, however uncertain positions are.
constexpr double share_of_inside = 0.25;

struct Ends {
  std::size_t firsts, count;
};
Ends ends_of(proximity::PairKind kind) {
  const auto firsts = static_cast<std::size_t>(proximity::first_nodes(kind));
  return {firsts, firsts + static_cast<std::size_t>(proximity::second_nodes(kind))};
}

// use(i, j) of a node of the first and one of the second primitive.
template <class Use>
void for_each_between(const Ends& ends, const Use& use) {
  for (std::size_t i = 0; i < ends.firsts; ++i)
    for (std::size_t j = ends.firsts; j < ends.count; ++j) use(i, j);
}

}  // namespace

BodyImpactSearch::BodyImpactSearch(Model& model, ContactEvents& events, const springnet_impact_search& search)
    : model_(model), search_(search), depths_(events.pair_depths()), tolerance_(model.contact_tolerance()) {
  for (const PairTouch& touch : model.constraints.bodies().touching()) touching_.insert(touch.key());
}

bool BodyImpactSearch::evaluate(double time, Instant& instant) {
  if (status_ != SPRINGNET_OK) return false;
  const std::size_t n = model_.node_count();
  instant.time = time;
  instant.values.resize(6 * n);
  double* const x = instant.values.data();
  const springnet_dense_output output{sizeof output, 0, time, {x, x + n, x + 2 * n}, {x + 3 * n, x + 4 * n, x + 5 * n}};
  status_ = search_.state_at(search_.user, &output);
  return status_ == SPRINGNET_OK;
}

proximity::Positions BodyImpactSearch::positions(const Instant& instant) const {
  const std::size_t n = model_.node_count();
  const double* const x = instant.values.data();
  return positions_of({x, x + n, x + 2 * n}, n);
}

double BodyImpactSearch::reach(const Watched& pair) const {
  return model_.constraints.bodies().primitives().thickness(pair.kind, pair.pair) - pair.depth;
}

bool BodyImpactSearch::is_inside(const Instant& at, const Watched& pair) const {
  const proximity::Primitives& all = model_.constraints.bodies().primitives();
  const proximity::Separation now = separation(pair.kind, all.corners(pair.kind, pair.pair, positions(at)));
  return now.distance <= reach(pair) && can_move(model_, all.nodes_of(pair.kind, pair.pair), now.weights) &&
         !is_said(at, pair, now);
}

bool BodyImpactSearch::is_said(const Instant& at, const Watched& pair, const proximity::Separation& now) const {
  return is_said_by_touching(model_.constraints.bodies(), pair.kind, pair.pair, now.weights, positions(at));
}

bool BodyImpactSearch::may_touch(const Instant& from, const Instant& until, const Watched& pair) const {
  const proximity::Primitives& all = model_.constraints.bodies().primitives();
  const std::size_t n = model_.node_count();
  const std::array<NodeIndex, 4> nodes = all.nodes_of(pair.kind, pair.pair);
  const std::array<Vector3, 4> start = all.corners(pair.kind, pair.pair, positions(from)),
                               end = all.corners(pair.kind, pair.pair, positions(until));
  const double h = until.time - from.time, reach = this->reach(pair);
  std::array<Vector3, 4> bent0, bent1;
  const Ends ends = ends_of(pair.kind);
  for (std::size_t i = 0; i < ends.count; ++i) {
    const std::size_t k = nodes[i];
    const auto velocity = [&](const Instant& at) {
      return Vector3(at.values[3 * n + k], at.values[4 * n + k], at.values[5 * n + k]);
    };
    bent0[i] = h * velocity(from) - (end[i] - start[i]);
    bent1[i] = h * velocity(until) - (end[i] - start[i]);
  }
  double travel = 0.0;  // m, of one relative to the other, at most
  for_each_between(ends, [&](std::size_t i, std::size_t j) {
    const Vector3 path = (end[i] - start[i]) - (end[j] - start[j]);
    travel = std::max(travel, path.norm() + bend_of((bent0[i] - bent0[j]).norm(), (bent1[i] - bent1[j]).norm()));
  });
  if (is_surely_beyond(pair.kind, start, std::max(0.0, reach) + travel)) return false;
  const proximity::Separation first = separation(pair.kind, start), last = separation(pair.kind, end);
  if (first.distance <= reach) return false;  // it is inside already
  if (last.distance <= reach) return !is_said(from, pair, first) || !is_said(until, pair, last);
  // What sinks in slowly while it slides fast would else be looked at in each of the many parts in which its distance
  // is the same but for rounding.
  double greatest = 0.0;
  for (std::size_t i = 0; i < ends.count; ++i)
    greatest = std::max({greatest, start[i].lpNorm<Eigen::Infinity>(), end[i].lpNorm<Eigen::Infinity>()});
  const double rounding = roundings_of_distance * std::numeric_limits<double>::epsilon() * greatest;
  const auto is_beyond = [&](const Vector3& n0, const Vector3& n1) {
    double least = std::numeric_limits<double>::infinity(), turn = 0.0, bend = 0.0;
    for_each_between(ends, [&](std::size_t i, std::size_t j) {
      const Vector3 before = start[i] - start[j], after = end[i] - end[j];
      least = std::min({least, n0.dot(before), n1.dot(after)});
      turn = std::max(turn, 0.25 * (n1 - n0).dot(after - before));
      for (const Vector3& along : {n0, n1})
        bend =
            std::max(bend, bend_of(std::abs(along.dot(bent0[i] - bent0[j])), std::abs(along.dot(bent1[i] - bent1[j]))));
    });
    return least - turn - bend > reach - rounding;
  };
  return !is_beyond(first.direction, first.direction) && !is_beyond(last.direction, last.direction) &&
         !is_beyond(first.direction, last.direction);
}

std::optional<double> BodyImpactSearch::first(const Instant& from, const Instant& until,
                                              const std::vector<Watched>& pairs, const Part& part) {
  if (until.time <= part.earliest || from.time >= part.latest || status_ != SPRINGNET_OK) return std::nullopt;
  std::vector<Watched> near;
  for (const Watched& pair : pairs)
    if (may_touch(from, until, pair)) near.push_back(pair);
  if (near.empty()) return std::nullopt;
  const double length = until.time - from.time;
  const double size = std::max(std::abs(until.time), search_.step_until - search_.step_from);
  if (length <= ImpactSearch::roundings * std::numeric_limits<double>::epsilon() * size) {
    const bool touches =
        std::any_of(near.begin(), near.end(), [&](const Watched& pair) { return is_inside(until, pair); });
    return touches ? std::optional(until.time) : std::nullopt;
  }
  Instant middle;
  if (!evaluate(from.time + 0.5 * length, middle)) return std::nullopt;
  const std::optional<double> early = first(from, middle, near, part);
  return early ? early : first(middle, until, near, part);
}

double BodyImpactSearch::greatest_bend(const Instant& from, const Instant& until) const {
  const std::size_t n = model_.node_count();
  const double h = until.time - from.time;
  double greatest = 0.0;
  for (const NodeIndex k : model_.constraints.bodies().primitives().nodes()) {
    Vector3 bent0, bent1;
    for (std::size_t c = 0; c < 3; ++c) {
      const double path = until.values[c * n + k] - from.values[c * n + k];
      bent0[static_cast<Eigen::Index>(c)] = h * from.values[(3 + c) * n + k] - path;
      bent1[static_cast<Eigen::Index>(c)] = h * until.values[(3 + c) * n + k] - path;
    }
    greatest = std::max(greatest, bend_of(bent0.norm(), bent1.norm()));
  }
  return greatest;
}

// The list is of straight paths: where others bend away from these too far for its skin, the time is halved.
std::optional<double> BodyImpactSearch::first_deep(const Instant& from, const Instant& until) {
  if (until.time <= search_.from || from.time >= search_.until || status_ != SPRINGNET_OK) return std::nullopt;
  BodyContacts& bodies = model_.constraints.bodies();
  const double apart = 2.0 * greatest_bend(from, until), length = until.time - from.time;
  if (apart > most_bend * bodies.list().skin() && length > shortest_part * (search_.step_until - search_.step_from)) {
    Instant middle;
    if (!evaluate(from.time + 0.5 * length, middle)) return std::nullopt;
    const std::optional<double> early = first_deep(from, middle);
    return early ? early : first_deep(middle, until);
  }
  bodies.list().update(positions(from), positions(until), std::min(apart, most_bend * bodies.list().skin()));
  std::vector<Watched> deep;
  for (const proximity::PairKind kind : proximity::pair_kinds)
    for (const proximity::Pair& pair : bodies.list().close(0.0)[kind]) {
      if (!is_watched(kind, pair)) continue;
      deep.push_back({kind, pair, depth_of(kind, pair) + uncertainty(kind, pair)});
      // What was missed touches as soon as it is found.
      if (is_inside(from, deep.back()) && approaches(from, deep.back())) return std::max(from.time, search_.from);
    }
  return first(from, until, deep, {search_.from, search_.until});
}

bool BodyImpactSearch::is_watched(proximity::PairKind kind, proximity::Pair pair) const {
  constexpr std::array<double, 4> any{1.0, 1.0, 1.0, 1.0};
  return !touching_.contains({kind, pair}) &&
         can_move(model_, model_.constraints.bodies().primitives().nodes_of(kind, pair), any);
}

double BodyImpactSearch::depth_of(proximity::PairKind kind, proximity::Pair pair) const {
  const auto known = depths_.find({kind, pair});
  return known == depths_.end() ? tolerance_ : known->second;
}

double BodyImpactSearch::uncertainty(proximity::PairKind kind, proximity::Pair pair) const {
  return std::min(search_.depth, share_of_inside * model_.constraints.bodies().primitives().thickness(kind, pair));
}

bool BodyImpactSearch::approaches(const Instant& at, const Watched& pair) const {
  const std::size_t n = model_.node_count();
  const double* const x = at.values.data();
  const PairMotion motion = pair_motion(model_.constraints.bodies(), pair.kind, pair.pair, {x, x + n, x + 2 * n},
                                        {x + 3 * n, x + 4 * n, x + 5 * n}, n);
  return motion.normal.dot(motion.velocity) < -model_.no_speed();
}

// First finds the time at which a pair is deep enough, then the time at which it began to touch.
springnet_status BodyImpactSearch::find(double& time) {
  const profile::Stage stage("proximity");
  time = std::numeric_limits<double>::quiet_NaN();
  Instant start, end, then;
  if (!evaluate(search_.step_from, start) || !evaluate(search_.step_until, end)) return status_;
  const std::optional<double> inside = first_deep(start, end);
  // What approaches behind its surface where the searched part ends has touched, too, however little: it falls on.
  if (!evaluate(inside.value_or(search_.until), then)) return status_;
  const auto margin = [&](proximity::PairKind kind, proximity::Pair pair) {
    return inside ? uncertainty(kind, pair) : 0.0;
  };
  std::vector<Watched> entered;
  proximity::NeighbourList& list = model_.constraints.bodies().list();
  list.update(positions(then));
  for (const proximity::PairKind kind : proximity::pair_kinds)
    for (const proximity::Pair& pair : list.close(0.0)[kind]) {
      const Watched each{kind, pair, depth_of(kind, pair)};
      if (is_watched(kind, pair) && is_inside(then, {kind, pair, each.depth + margin(kind, pair)}) &&
          (inside || (!is_inside(start, each) && approaches(then, each))))
        entered.push_back(each);
    }
  // No earlier than the start of the searched part: earlier searches found no pair deep enough.
  if (entered.empty() && !inside) return status_;
  const std::optional<double> begins = first(start, then, entered, {search_.step_from, then.time});
  if (status_ != SPRINGNET_OK) return status_;
  time = std::max(search_.from, begins ? first_approach(*begins, then, entered) : then.time);
  return status_;
}

// Right after a restart the interpolated velocity is not the derivative of the interpolated position, and may still be
// that with which a pair parted where its gap has closed again already.
double BodyImpactSearch::first_approach(double from, const Instant& until, const std::vector<Watched>& pairs) {
  Instant at;
  const auto touches = [&](const Instant& instant) {
    return std::any_of(pairs.begin(), pairs.end(),
                       [&](const Watched& pair) { return is_inside(instant, pair) && approaches(instant, pair); });
  };
  if (!evaluate(from, at) || touches(at) || !touches(until)) return from;
  constexpr double precise = 1e-3;  // of the time between
  double early = from, late = until.time;
  while (late - early > precise * (until.time - from)) {
    const double middle = 0.5 * (early + late);
    if (!evaluate(middle, at)) return from;
    (touches(at) ? late : early) = middle;
  }
  return late;
}

}  // namespace springnet
