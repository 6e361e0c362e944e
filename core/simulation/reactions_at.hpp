// Reactions of nodes at some state, evaluated as they are asked for; a cluster's all at once.
#pragma once

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
  // The same as it is told: what presses over a step of the network may pull at its end, where it then leaves. There it
  // is zero. `withheld`: that pull, if wanted.
  springnet_status told(std::uint32_t node, Vector3& reaction, Vector3* withheld = nullptr);
  // What the node would do if no surface held it now that does not yet, with its rigid connections, m/s^2.
  springnet_status acceleration(std::uint32_t node, Vector3& acceleration);
  // The same if no surface acted, nor rigid connections.
  springnet_status unsupported(std::uint32_t node, Vector3& acceleration);
  [[nodiscard]] Vector3 position(std::uint32_t node) const;
  [[nodiscard]] Vector3 velocity(std::uint32_t node) const;
  // Evaluates a cluster, so that its tensions are known.
  springnet_status know(std::uint32_t cluster);
  [[nodiscard]] const Placement& placement() const noexcept { return *placement_; }
  [[nodiscard]] const std::vector<double>& tensions() const noexcept { return tension_; }  // [rod] N

 private:
  springnet_status free_acceleration(std::uint32_t node, Vector3& acceleration);
  springnet_status of_cluster(std::uint32_t cluster, std::uint32_t node, Vector3& reaction);

  Engine& engine_;
  double time_;
  springnet_const_vectors position_, velocity_;
  layers::ExternalForces external_;
  std::shared_ptr<const Placement> placement_;
  layers::SurfaceVolumes volumes_;
  std::vector<std::uint8_t> cluster_known_;
  std::vector<double> free_, bound_;  // [3 node] m/s^2
  std::vector<double> tension_;       // [rod] N
};

}  // namespace springnet
