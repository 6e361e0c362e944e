// Continuous collision detection of bodies within a step with dense output: the time at which a pair that does not
// touch first does, even if it has separated again by the end.
//
// With any direction n, |n| <= 1, the distance of a pair is at least the least n.(a - b) of a node a of its first and a
// node b of its second primitive, and equal to it where n is the pair's direction. If n goes from n0 to n1 on a
// straight line between two times, as x = a - b does but for its bend, then n.x is at least the lesser of n0.x0 and
// n1.x1, less (n1 - n0).(x1 - x0) / 4 and the bend. Where that does not exclude a touch, the time between is halved.
// With n0 and n1 both directions of the pair these losses are of second order, also for what turns while it touches
// elsewhere.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "simulation/contact_events.hpp"
#include "simulation/model.hpp"

namespace springnet {

class BodyImpactSearch {
 public:
  // events: their depths of pairs.
  BodyImpactSearch(Model& model, ContactEvents& events, const springnet_impact_search& search);
  // As ImpactSearch::find. Throws as proximity::PairSearch::find.
  springnet_status find(double& time);

 private:
  struct Watched {
    proximity::PairKind kind;
    proximity::Pair pair;
    double depth;  // m: it touches at this gap below 0
  };
  // All nodes at one time: [6 node], positions, then velocities, by components.
  struct Instant {
    double time;
    std::vector<double> values;
  };
  struct Part {
    double earliest, latest;  // s
  };
  [[nodiscard]] bool evaluate(double time, Instant& instant);
  [[nodiscard]] proximity::Positions positions(const Instant& instant) const;
  [[nodiscard]] double reach(const Watched& pair) const;  // m: the distance at which it touches
  [[nodiscard]] bool is_inside(const Instant& at, const Watched& pair) const;
  // Another pair that touches says the same.
  [[nodiscard]] bool is_said(const Instant& at, const Watched& pair, const proximity::Separation& now) const;
  // It does not touch yet, and some of its nodes can move.
  [[nodiscard]] bool is_watched(proximity::PairKind kind, proximity::Pair pair) const;
  [[nodiscard]] bool may_touch(const Instant& from, const Instant& until, const Watched& pair) const;
  [[nodiscard]] std::optional<double> first(const Instant& from, const Instant& until,
                                            const std::vector<Watched>& pairs, const Part& part);
  // s: when one of these, the first of which is inside at `from`, is inside and approaches.
  [[nodiscard]] double first_approach(double from, const Instant& until, const std::vector<Watched>& pairs);

  // m: a bound on how far paths are from straight ones.
  [[nodiscard]] double greatest_bend(const Instant& from, const Instant& until) const;
  [[nodiscard]] std::optional<double> first_deep(const Instant& from, const Instant& until);
  [[nodiscard]] double depth_of(proximity::PairKind kind, proximity::Pair pair) const;     // m
  [[nodiscard]] double uncertainty(proximity::PairKind kind, proximity::Pair pair) const;  // m
  [[nodiscard]] bool approaches(const Instant& at, const Watched& pair) const;

  Model& model_;
  const springnet_impact_search& search_;
  const std::map<std::pair<proximity::PairKind, proximity::Pair>, double>& depths_;
  std::set<std::pair<proximity::PairKind, proximity::Pair>> touching_;
  double tolerance_;  // m
  springnet_status status_ = SPRINGNET_OK;
};

}  // namespace springnet
