// Continuous collision detection: when a node first touches a surface within a step whose states are known at all its
// times, also where it has left the surface again by the end.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "simulation/engine.hpp"

namespace springnet {

class Engine::ImpactSearch {
 public:
  ImpactSearch(Engine& engine, const springnet_impact_search& search);
  // s; nan: nothing touches.
  springnet_status find(double& time);

 private:
  // A node that surfaces do not hold, and one of them that it does not touch; it counts as touching from `depth`, m,
  // behind the surface.
  struct Pair {
    std::uint32_t node;
    std::uint32_t surface;
    double depth;
  };
  struct Instant {
    double time;
    std::shared_ptr<const Placement> at;
    std::vector<double> values;  // [6 node]: positions, then velocities, by components
  };
  [[nodiscard]] std::optional<Instant> instant(double time);
  [[nodiscard]] Vector3 position(const Instant& instant, std::uint32_t node) const;
  [[nodiscard]] Vector3 velocity(const Instant& instant, std::uint32_t node) const;
  [[nodiscard]] double value(const Instant& instant, const Pair& pair) const;  // m; below 0: behind
  // Whether a pair has, or may have, a value below 0 between two instants.
  [[nodiscard]] bool comes_near(const Instant& from, const Instant& until, const Pair& pair, bool short_part) const;
  // The first time at which one has, to rounding, in the part from `earliest` to `latest`, s.
  struct Part {
    double earliest, latest;
  };
  [[nodiscard]] std::optional<double> first(const Instant& from, const Instant& until, const std::vector<Pair>& pairs,
                                            const Part& part);

  Engine& engine_;
  const springnet_impact_search& search_;
  std::vector<Pair> pairs_;
  double longest_;  // s, between instants: the surfaces turn and swing by no more than a tenth of a turn
  springnet_status status_ = SPRINGNET_OK;
};

}  // namespace springnet
