// Books the impulses of obstacles and fixation in a step of sweeps, so that momentum balances. Over the step each node
// has
//
//   m (v' - v) = h ((1 - theta) (F + R) + theta F') + J,
//
// with F forces and R reactions at the start, primed at the end, and J the impulses of the sweeps. The part of J that
// is reported as a force of an obstacle is h ((1 - theta) R + theta R'). The rest is booked as an impulse: that of the
// impact if a node touched, otherwise an error of the method's order. Fixed and moved nodes are treated alike, with the
// impulses of their rigid connections.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "simulation/model.hpp"
#include "simulation/reactions_at.hpp"
#include "simulation/sweep.hpp"

namespace springnet {

class ImpulseLedger {
 public:
  explicit ImpulseLedger(Model& model) : model_(model) {}

  // Before the first sweep of a step, at the committed state.
  springnet_status begin_step();
  // After the last sweep, once its state is committed: commits the contacts that the sweeps decided, records their
  // events, and adds up impulses. before: the state before the step.
  springnet_status commit(const Sweep::Done& done, const State& before);
  void take_over(const ImpulseLedger& before, const layers::NumbersBefore& numbers) {
    if (before.withheld_.empty()) return;
    withheld_.assign(model_.node_count(), Vector3::Zero());
    numbers.for_each_node([&](std::uint32_t k, std::uint32_t old) { withheld_[k] = before.withheld_[old]; });
  }
  // At a committed state.
  void archive(Archive& archive) {
    withheld_.resize(archive.count(withheld_.size(), 3 * sizeof(double), "impulses"), Vector3::Zero());
    if (!withheld_.empty() && withheld_.size() != model_.node_count()) Archive::refuse("impulses of another network");
    for (Vector3& each : withheld_) archive.vector(each);
  }

 private:
  // A cluster with fixed nodes at the start of the step: [node of the cluster] m/s, m/s^2.
  struct AnchoredCluster {
    std::size_t cluster;
    std::vector<Vector3> velocity, acceleration;
  };
  springnet_status begin_anchored();
  // Books an impulse (N s) of `surfaces` on a node. Returns the share of each surface.
  std::vector<Vector3> book_contact(std::uint32_t node, const std::vector<std::int32_t>& surfaces, const Placement& at,
                                    const Vector3& impulse);
  // Books what the prescribed motion of a node needs beyond its accelerations.
  void book_motion(std::uint32_t node, const Placement& end);
  [[nodiscard]] Vector3 own_part_of_push(std::uint32_t node, const Placement& at) const;
  [[nodiscard]] std::map<std::uint32_t, Vector3> pushes_on_clusters() const;
  // Rods gave the free nodes the impulses that forces, reactions and obstacles did not; the fixation of the other nodes
  // bears the opposite.
  springnet_status book_anchored(const AnchoredCluster& anchored, ReactionsAt& reactions);

  Model& model_;
  Sweep::Done done_;
  std::vector<Vector3> withheld_;  // [node] N: left out by ReactionsAt::reported() at the last commit; may be empty
  std::vector<AnchoredCluster> anchored_;
};

}  // namespace springnet
