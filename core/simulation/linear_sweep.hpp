// Sweeps of the linearised network, node by node: the effect of an integrator's update rule on small changes of the
// outputs. See springnet_host::linear_sweep.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <springnet/sdk/plugin.h>

#include "constraints/constraint_set.hpp"
#include "layers/linear/linearisation.hpp"

namespace springnet {

class LinearSweep {
 public:
  // Valid until the next linearise(). References must outlive it.
  LinearSweep(layers::Linearisation& linearisation, const ConstraintSet& constraints, const std::vector<double>& mass);

  // Request and order must have been checked.
  void run(const springnet_sweep& sweep);

 private:
  // Nodes coupled by constraints, which are updated together: a cluster of rigid connections, with the surfaces that
  // its nodes slide on, or a single sliding node.
  struct Island {
    std::vector<std::uint32_t> nodes;
    std::vector<ConstraintRow> rows;
    std::unique_ptr<ConstraintSystem> system = std::make_unique<ConstraintSystem>();
    std::vector<double> inertia;  // [node][9] that the system was factorised with
    bool is_factorised = false, is_done = false;
  };
  void set_weight(double weight);
  void find_blocks();
  [[nodiscard]] Vector3 velocity(std::uint32_t node) const;
  void call_update(std::uint32_t node, const Vector3& acceleration);
  // Applies fixation to the outputs of a node, and updates enclosures.
  void finish(std::uint32_t node, const Vector3& before);
  void update_island(Island& island);
  void factorise(Island& island);
  [[nodiscard]] Vector3 acceleration(std::uint32_t node) const;

  layers::Linearisation& linearisation_;
  const ConstraintSet& constraints_;
  const std::vector<double>& mass_;
  double weight_ = 0.0;                            // s: position changes are this times velocity changes
  std::vector<double> own_;                        // [node][9] own block of da/dv + weight da/dp
  std::vector<double> by_velocity_, by_position_;  // [node][9] of each of them, where batches have blocks; else empty
  std::vector<std::uint32_t> island_of_;           // [node]
  std::vector<Island> islands_;
  const springnet_sweep* sweep_ = nullptr;  // running
  const double* u_[3]{};                    // its velocities
  std::vector<Vector3> members_, before_;   // of an island
};

}  // namespace springnet
