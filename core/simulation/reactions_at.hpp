// Reactions of nodes at a state, computed on demand, for a cluster all at once.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "layers/elements/enclosure_volumes.hpp"
#include "simulation/body_motion.hpp"
#include "simulation/model.hpp"

namespace springnet {

// Forces that hold, move or stop nodes.
struct Reactions {
  std::vector<Vector3> node;  // [node] N, of fixation and obstacles; 0 for free nodes
  std::vector<double> rigid;  // [rod] N, > 0 is tension
};
// At the committed state, with these forces of pairs that touch, N. Throws Error(simulation) if a law fails.
[[nodiscard]] Reactions reactions_now(Model& model, const std::vector<Vector3>& of_pairs);

// What these forces of pairs that touch, N, do to nodes: a node several times if several touch it.
void for_each_body_force(const Model& model, const std::vector<Vector3>& of_pairs,
                         const std::function<void(std::uint32_t, const Vector3&)>& use);

class ReactionsAt {
 public:
  // The arrays must outlive it. internal: states of laws; `placement`: of obstacles and prescribed nodes; null: that of
  // the time.
  ReactionsAt(Model& model, double time, const springnet_const_vectors& position,
              const springnet_const_vectors& velocity, const layers::InternalView& internal,
              std::shared_ptr<const Placement> placement = nullptr);
  // The internal states are those committed.
  ReactionsAt(Model& model, double time, const springnet_const_vectors& position,
              const springnet_const_vectors& velocity)
      : ReactionsAt(model, time, position, velocity, model.state.internal) {}
  // Evaluates nodes, in ascending order, at once: what is asked of them then costs less.
  springnet_status prepare(std::vector<std::uint32_t> nodes);
  // In place of it: accelerations of these nodes without obstacles and rigid connections, m/s^2.
  void give(std::vector<std::uint32_t> nodes, std::vector<Vector3> accelerations) {
    prepared_ = std::move(nodes);
    prepared_acceleration_ = std::move(accelerations);
  }
  // Forces of bodies in contact on nodes with rigid connections, N, where a step found them: what holds the others of
  // the cluster bears them, too.
  void add_forces(std::map<std::uint32_t, Vector3> forces) { added_ = std::move(forces); }
  // The force of fixation or obstacles on a node, N.
  springnet_status of(std::uint32_t node, Vector3& reaction);
  // The same without the bracing of sticking nodes against each other.
  springnet_status unbraced(std::uint32_t node, Vector3& reaction);
  // The force to report. An obstacle that presses over a step of the network may pull at the end of the step, where the
  // node separates: its share is zero. Sticking friction may lie outside its cone at the end, where the node slips: it
  // is cut to the cone. `withheld`: the part left out, if wanted.
  springnet_status reported(std::uint32_t node, Vector3& reaction, Vector3* withheld = nullptr);
  // For a node with rigid connections, with these and all contacts of its cluster; for any other node, without its own
  // contact and friction, m/s^2.
  springnet_status acceleration(std::uint32_t node, Vector3& acceleration);
  // With all constraints, m/s^2.
  springnet_status constrained(std::uint32_t node, Vector3& acceleration);
  // Without obstacles and rigid connections, m/s^2.
  springnet_status unsupported(std::uint32_t node, Vector3& acceleration);
  // The same as if nothing fixed or moved it, m/s^2.
  springnet_status unfixed(std::uint32_t node, Vector3& acceleration) { return free_acceleration(node, acceleration); }
  // What bodies that touch do, where their events are located; null: none touch.
  springnet_status bodies(const BodyMotion*& motion);
  // Treats this node as free of contact from now on.
  void leave_out(std::uint32_t node) {
    without_ = node;
    std::fill(cluster_known_.begin(), cluster_known_.end(), std::uint8_t{0});
    bracing_.clear();
    bodies_.reset();
  }
  [[nodiscard]] Vector3 position(std::uint32_t node) const;
  [[nodiscard]] Vector3 velocity(std::uint32_t node) const;
  // Computes accelerations and tensions of a cluster.
  springnet_status know(std::uint32_t cluster);
  // Acceleration of a node whose cluster is known: without rigid connections and obstacles, and with them, m/s^2.
  [[nodiscard]] Vector3 free(std::uint32_t node) const { return part(free_, node); }
  [[nodiscard]] Vector3 constrained(std::uint32_t node) const { return part(constrained_, node); }
  [[nodiscard]] const springnet_const_vectors& all_positions() const noexcept { return position_; }
  [[nodiscard]] const springnet_const_vectors& all_velocities() const noexcept { return velocity_; }
  [[nodiscard]] const Placement& placement() const noexcept { return *placement_; }
  [[nodiscard]] const std::vector<double>& tensions() const noexcept { return tension_; }  // [rod] N

 private:
  springnet_status free_acceleration(std::uint32_t node, Vector3& acceleration);
  void brace(std::uint32_t cluster);
  // Of a node without rigid connections, from its acceleration without obstacles.
  [[nodiscard]] Vector3 held(std::uint32_t node, Vector3 acceleration) const;
  [[nodiscard]] Vector3 part(const std::vector<double>& values, std::uint32_t node) const {
    const std::size_t n = values.size() / 3;
    return {values[node], values[n + node], values[2 * n + node]};
  }
  springnet_status of_cluster(std::uint32_t cluster, std::uint32_t node, Vector3& reaction);

  Model& model_;
  double time_;
  layers::InternalView internal_;
  springnet_const_vectors position_, velocity_;
  layers::ExternalForces external_;
  std::shared_ptr<const Placement> placement_;
  layers::EnclosureVolumes volumes_;
  std::vector<std::uint32_t> prepared_;         // nodes,
  std::vector<Vector3> prepared_acceleration_;  // and theirs, without obstacles and rigid connections, m/s^2
  std::map<std::uint32_t, Vector3> added_;      // [node] N
  std::uint32_t without_ = ConstraintRow::no_node;
  std::vector<std::uint8_t> cluster_known_;
  std::vector<double> free_, constrained_;  // [3 node] m/s^2
  std::vector<double> tension_;             // [rod] N
  std::vector<double> bracing_;             // [rod] N, part of tension_ by bracing; empty: none
  std::optional<BodyMotion> bodies_;        // empty: not asked for yet
};

}  // namespace springnet
