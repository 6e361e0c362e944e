// The impulses of obstacles and fixation in a step of sweeps, so that momentum balances. Over the step each node has
//
//   m (v' - v) = h ((1 - theta) (F + R) + theta F') + J,
//
// F forces, R reactions at its start, primes at its end, J impulses of the sweeps. The part of J that appears as a
// force of an obstacle is h ((1 - theta) R + theta R'); the rest is an impulse: the blow where a node touched,
// otherwise the error of the method's order. What holds or moves a node gets the same from the rigid connections of the
// node.
#pragma once

#include <cstdint>
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
  // After the last one, once its state is committed: the contacts that sweeps decided become the committed ones, with
  // their events, and impulses are added up.
  springnet_status commit(const Sweep::Done& done);

 private:
  // A cluster with fixed nodes, as the step began: [node of the cluster] m/s, m/s^2.
  struct AnchoredCluster {
    std::size_t cluster;
    std::vector<Vector3> velocity, acceleration;
  };
  springnet_status begin_anchored();
  // N s, by `surfaces` and fixation on a node. Returns the part of each surface.
  std::vector<Vector3> book_contact(std::uint32_t node, const std::vector<std::int32_t>& surfaces, const Placement& at,
                                    const Vector3& impulse);
  // What moves a node gives it the impulse that its acceleration does not.
  void book_motion(std::uint32_t node, const Placement& end);
  // Rods gave the nodes that can move the impulse that forces, reactions and obstacles did not; what holds the other
  // nodes bears the opposite of theirs.
  springnet_status book_anchored(const AnchoredCluster& anchored, ReactionsAt& reactions);

  Model& model_;
  Sweep::Done done_;
  std::vector<Vector3> withheld_;  // [node] N: what ReactionsAt::reported() left out at the last commit; may be empty
  std::vector<AnchoredCluster> anchored_;
};

}  // namespace springnet
