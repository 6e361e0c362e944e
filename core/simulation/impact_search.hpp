// Continuous collision detection: the time at which a node first touches an obstacle within a step with dense output,
// even if it has separated again by the end.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "simulation/contact_events.hpp"
#include "simulation/model.hpp"

namespace springnet {

// Bound on the distance between a path and its chord, m: twice that of Hermite's cubic, h (s (1-s)^2 (u0 - c) -
// s^2 (1-s) (u1 - c)) with velocities u at its ends and c = chord / h, which is at most 4/27 h (|u0 - c| + |u1 - c|).
inline double bend_of(double bent0, double bent1) { return 2.0 * 4.0 / 27.0 * (bent0 + bent1); }

class ImpactSearch {
 public:
  // Times that differ by this many roundings are the same.
  static constexpr double roundings = 16.0;
  // Searches the touches among these events; see springnet_host::time_of_impact.
  ImpactSearch(const Model& model, const std::vector<ContactEvents::Source>& sources,
               const springnet_impact_search& search);
  // time: s; nan if nothing touches.
  springnet_status find(double& time);

 private:
  // A node and an obstacle that are not in contact; they touch from `depth`, m, behind the surface.
  struct Pair {
    std::uint32_t node;
    std::uint32_t surface;
    double depth;
  };
  // All nodes at one time: [6 node], positions, then velocities, by components.
  struct Snapshot {
    double time;
    std::shared_ptr<const Placement> at;
    std::vector<double> values;
  };
  // The node of a pair at one time.
  struct NodeState {
    Vector3 position, velocity;  // m, m/s
    double gap;                  // m
  };
  // Some pairs at one time.
  struct Instant {
    double time;
    std::shared_ptr<const Placement> at;
    std::vector<NodeState> states;  // [pair]
  };
  struct Part {
    double earliest, latest;  // s
  };
  [[nodiscard]] bool evaluate(double time, Snapshot& snapshot);
  [[nodiscard]] NodeState node_state(const Snapshot& snapshot, const Pair& pair) const;
  [[nodiscard]] Instant instant(const Snapshot& snapshot, const std::vector<Pair>& pairs) const;
  // Whether the gap of a pair is, or may be, below -depth between two times.
  [[nodiscard]] bool comes_near(const Instant& from, const Instant& until, const Pair& pair, const NodeState& a,
                                const NodeState& b, bool short_part) const;
  // The same between times so far apart that the obstacle may swing or turn far in between.
  [[nodiscard]] bool may_reach(const Instant& from, const Instant& until, const Pair& pair, const NodeState& a,
                               const NodeState& b) const;
  // The first time in a part at which a gap is below -depth, to rounding.
  [[nodiscard]] std::optional<double> first(const Instant& from, const Instant& until, const std::vector<Pair>& pairs,
                                            const Part& part);

  const Model& model_;
  const springnet_impact_search& search_;
  std::vector<Pair> pairs_;
  std::vector<double> longest_;  // [obstacle] s, time in which it turns and swings by at most a tenth of a turn
  Snapshot between_{};           // at the last time evaluated
  springnet_status status_ = SPRINGNET_OK;
};

}  // namespace springnet
