// Continuous collision detection: when a node first touches an obstacle within a step whose states are known at all
// times, also if it has separated again by the end.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "simulation/contact_events.hpp"
#include "simulation/model.hpp"

namespace springnet {

class ImpactSearch {
 public:
  // As in springnet_host::time_of_impact, of the touches among these events.
  ImpactSearch(const Model& model, const std::vector<ContactEvents::Source>& sources,
               const springnet_impact_search& search);
  // s; nan: nothing touches.
  springnet_status find(double& time);

 private:
  // A node and an obstacle that are not in contact; they touch from `depth`, m, behind the surface.
  struct Pair {
    std::uint32_t node;
    std::uint32_t surface;
    double depth;
  };
  // All nodes at a time: [6 node], positions, then velocities, by components.
  struct Whole {
    double time;
    std::shared_ptr<const Placement> at;
    std::vector<double> values;
  };
  // The node of a pair at a time.
  struct Place {
    Vector3 position, velocity;  // m, m/s
    double gap;                  // m
  };
  // Some pairs at a time.
  struct Instant {
    double time;
    std::shared_ptr<const Placement> at;
    std::vector<Place> places;  // [pair]
  };
  struct Part {
    double earliest, latest;  // s
  };
  [[nodiscard]] bool evaluate(double time, Whole& whole);
  [[nodiscard]] Place place(const Whole& whole, const Pair& pair) const;
  [[nodiscard]] Instant instant(const Whole& whole, const std::vector<Pair>& pairs) const;
  // Whether a pair has, or may have, a gap below -depth between two times.
  [[nodiscard]] bool comes_near(const Instant& from, const Instant& until, const Pair& pair, const Place& a,
                                const Place& b, bool short_part) const;
  // The same between times so far apart that the obstacle may swing or turn unseen.
  [[nodiscard]] bool may_reach(const Instant& from, const Instant& until, const Pair& pair, const Place& a,
                               const Place& b) const;
  // The first time in a part at which one has, to rounding.
  [[nodiscard]] std::optional<double> first(const Instant& from, const Instant& until, const std::vector<Pair>& pairs,
                                            const Part& part);

  const Model& model_;
  const springnet_impact_search& search_;
  std::vector<Pair> pairs_;
  std::vector<double> longest_;  // [obstacle] s, in which it turns and swings by at most a tenth of a turn
  Whole between_{};              // at the last time
  springnet_status status_ = SPRINGNET_OK;
};

}  // namespace springnet
