// Processing of finished tiles in an evaluation or a sweep: forces to accelerations and, in a sweep, the integrator's
// update of nodes.
#pragma once

#include <atomic>
#include <span>

#include "simulation/sweep.hpp"

namespace springnet {

struct Sweep::Tiles {
  Model& model;
  const Placement* at;  // obstacles and prescribed nodes at `time`
  double time;          // s
  layers::NodeArrays nodes;
  layers::ForceArrays force;
  const springnet_sweep* sweep = nullptr;  // null: an evaluation
  springnet_vectors acceleration{};        // of an evaluation; null: not wanted
  springnet_vectors free{};                // the same without constraints
  std::atomic<bool> finite{true};
  std::atomic<bool> outputs_finite{true};  // of a sweep without an order
  std::atomic<std::uint32_t> bad_neuron{
      ConstraintRow::no_node};  // first node with finite force but acceleration not finite

  // A tile of an evaluation: accelerations of the constrained motion.
  springnet_status accelerate(std::uint32_t first, std::uint32_t count, const double* const of_tile[3],
                              bool forces_finite, springnet_message& message);
  // A tile of a sweep: the integrator's update of nodes, then their constraints.
  springnet_status update(std::uint32_t unit, std::uint32_t first, std::uint32_t count, const double* const of_tile[3],
                          bool forces_finite, const layers::NodeDerivatives* derivatives, springnet_message& message);
  // Nodes of an order, whose old values are `own`, with their accelerations, [component][i] of nodes[i].
  springnet_status update(std::uint32_t unit, std::span<const std::uint32_t> nodes, const layers::ListedNodes& own,
                          const double* const force_of[3], const double* const acceleration_of[3],
                          springnet_message& message);

  [[nodiscard]] bool all_finite(const double* const values[3], std::uint32_t count) const noexcept;
  // Notes nodes of a list whose acceleration is not finite although their force is.
  void note_bad_neurons(std::span<const std::uint32_t> list, const double* const force_of[3],
                        const double* const acceleration_of[3]);

 private:
  void note_bad_neuron(std::uint32_t first, std::uint32_t count, const double* const acceleration_of[3]);
};

struct Sweep::NodeEvaluation {
  layers::NodeDerivatives derivatives;
  bool finite;
};

}  // namespace springnet
