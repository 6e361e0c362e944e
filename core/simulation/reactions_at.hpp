// Reactions of nodes at some state, evaluated as they are asked for; a cluster's all at once.
#pragma once

#include <algorithm>
#include <vector>

#include "simulation/engine.hpp"

namespace springnet {

class Engine::ReactionsAt {
 public:
  // The arrays have to outlive it.
  ReactionsAt(Engine& engine, double time, const springnet_const_vectors& position,
              const springnet_const_vectors& velocity);
  // The force of fixation or a surface on the node, N.
  springnet_status of(std::uint32_t node, Vector3& reaction);
  // The same without what nodes that stick brace themselves with.
  springnet_status unbraced(std::uint32_t node, Vector3& reaction);
  // The same as it is told: what presses over a step of the network may pull at its end, where it then leaves. Of such
  // a surface it is zero. `withheld`: that pull, if wanted.
  springnet_status told(std::uint32_t node, Vector3& reaction, Vector3* withheld = nullptr);
  // What the node would do if no surface held it now that does not yet, with its rigid connections, m/s^2.
  springnet_status acceleration(std::uint32_t node, Vector3& acceleration);
  // What it does, with all that holds it, m/s^2.
  springnet_status bound(std::uint32_t node, Vector3& acceleration);
  // What it would do if no surface acted, nor rigid connections.
  springnet_status unsupported(std::uint32_t node, Vector3& acceleration);
  // From now on as if this node had been let go, which it has not.
  void leave_out(std::uint32_t node) {
    without_ = node;
    std::fill(cluster_known_.begin(), cluster_known_.end(), std::uint8_t{0});
    bracing_.clear();
  }
  [[nodiscard]] Vector3 position(std::uint32_t node) const;
  [[nodiscard]] Vector3 velocity(std::uint32_t node) const;
  // Evaluates a cluster, so that its tensions are known.
  springnet_status know(std::uint32_t cluster);
  // Of a node whose cluster is known: without connections and surfaces, and with them, m/s^2.
  [[nodiscard]] Vector3 free(std::uint32_t node) const { return part(free_, node); }
  [[nodiscard]] Vector3 bound(std::uint32_t node) const { return part(bound_, node); }
  [[nodiscard]] const Placement& placement() const noexcept { return *placement_; }
  [[nodiscard]] const std::vector<double>& tensions() const noexcept { return tension_; }  // [rod] N

 private:
  springnet_status free_acceleration(std::uint32_t node, Vector3& acceleration);
  void brace(std::uint32_t cluster);
  // Of a lone node, from its acceleration without surfaces.
  [[nodiscard]] Vector3 held(std::uint32_t node, Vector3 acceleration) const;
  [[nodiscard]] Vector3 part(const std::vector<double>& values, std::uint32_t node) const {
    const std::size_t n = values.size() / 3;
    return {values[node], values[n + node], values[2 * n + node]};
  }
  springnet_status of_cluster(std::uint32_t cluster, std::uint32_t node, Vector3& reaction);

  Engine& engine_;
  double time_;
  springnet_const_vectors position_, velocity_;
  layers::ExternalForces external_;
  std::shared_ptr<const Placement> placement_;
  layers::EnclosureVolumes volumes_;
  std::uint32_t without_ = ConstraintRow::no_node;
  std::vector<std::uint8_t> cluster_known_;
  std::vector<double> free_, bound_;  // [3 node] m/s^2
  std::vector<double> tension_;       // [rod] N
  std::vector<double> bracing_;       // the part of it that braces; empty: none
};

}  // namespace springnet
