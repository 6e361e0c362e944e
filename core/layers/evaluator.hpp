// Evaluation of the spring layer, elements and the node layer: from positions and velocities to net forces and
// accelerations.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "layers/elements/enclosure_volumes.hpp"
#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// Forces that do not depend on springs.
struct ExternalForces {
  Vector3 gravity = Vector3::Zero();  // m/s^2
  ForceArrays loads{};                // N, [node]; null: none
  const double* pressure = nullptr;   // Pa, [load]: those that follow their faces; null: none
};

// A tile whose net forces are final: nodes [first, first + count). Called by the thread that computed them; a status
// other than SPRINGNET_OK ends the evaluation like that of a law.
struct TileFinished {
  springnet_status (*call)(void* user, std::uint32_t unit, std::uint32_t first, std::uint32_t count,
                           springnet_message& message) = nullptr;
  void* user = nullptr;
};

// How one node's acceleration depends on its own velocity and position, the other nodes staying as they are; row-major.
struct NodeDerivatives {
  double by_velocity[9];  // da/dv, 1/s
  double by_position[9];  // da/dp, 1/s^2
};

class Evaluator {
 public:
  // References have to outlive the evaluator. mass: [node] kg.
  Evaluator(const Layout& layout, const std::vector<double>& mass, InstructionSet set, unsigned threads);

  [[nodiscard]] InstructionSet instruction_set() const noexcept { return set_; }
  [[nodiscard]] unsigned threads() const noexcept { return threads_; }

  // Net force on every node, in tiles and threads; the sums have the same order for every number of threads. Returns
  // the status of the first unit in which a law failed. Does not throw. One call at a time: elements are evaluated into
  // memory of the evaluator first.
  springnet_status evaluate(double time, const NodeArrays& nodes, const ExternalForces& external,
                            const ForceArrays& force, TileFinished finished, springnet_message& message) const;
  // Net force on one node: all its springs and elements, evaluated plainly. volumes: those of closed enclosures at this
  // state; null: they are computed here, from all their nodes.
  springnet_status evaluate_node(std::uint32_t node, double time, const NodeArrays& nodes,
                                 const ExternalForces& external, const EnclosureVolumes* volumes, Vector3& force,
                                 springnet_message& message) const;
  // The same, the acceleration by the node's neuron, and what is wanted of its derivatives and its energy (J): that of
  // its springs and elements less the work of gravity and loads, nan where no potential exists (a law without energy or
  // one that reads the rate, a neuron other than force over mass). SPRINGNET_FAILED if derivatives are wanted and a law
  // or the neuron has none.
  springnet_status evaluate_node(std::uint32_t node, double time, const NodeArrays& nodes,
                                 const ExternalForces& external, const EnclosureVolumes* volumes, Vector3& force,
                                 Vector3& acceleration, NodeDerivatives* derivatives, double* energy,
                                 springnet_message& message) const;
  // Acceleration of nodes [first, first + count) of their neurons. `force` and `acceleration` are [count] arrays;
  // blocks [count][9] may be null.
  springnet_status accelerations(std::uint32_t first, std::uint32_t count, double time, const NodeArrays& nodes,
                                 const double* const force[3], double* const acceleration[3], double* by_force,
                                 double* by_position, double* by_velocity, springnet_message& message) const;

 private:
  springnet_status evaluate_unit(std::uint32_t unit, double time, const NodeArrays& nodes,
                                 const ExternalForces& external, const ForceArrays& force, TileFinished finished,
                                 springnet_message& message) const;
  springnet_status evaluate_segment(const Unit& unit, const Segment& segment, double time, const NodeArrays& nodes,
                                    const ForceArrays& force, SegmentGeometry& geometry,
                                    springnet_message& message) const;

  // Of all elements: dq/dp of each node and Q, before the units add them up.
  springnet_status evaluate_elements(double time, const NodeArrays& nodes, springnet_message& message) const;
  springnet_status evaluate_batch(const ElementBatch& batch, double time, const NodeArrays& nodes,
                                  springnet_message& message) const;
  springnet_status evaluate_enclosures(double time, springnet_message& message) const;
  void add_elements(std::uint32_t begin, std::uint32_t end, const ForceArrays& force) const noexcept;

  struct NodeSums;
  springnet_status add_springs(std::uint32_t node, double time, const NodeArrays& nodes, NodeSums& sums,
                               springnet_message& message) const;
  springnet_status add_elements_of(std::uint32_t node, double time, const NodeArrays& nodes,
                                   const EnclosureVolumes* volumes, NodeSums& sums, springnet_message& message) const;

  const Layout& layout_;
  const std::vector<double>& mass_;
  InstructionSet set_;
  const Kernels& kernels_;
  unsigned threads_;
  // What an evaluation knows of elements: it is made and used within one call.
  struct Chunk {
    std::uint32_t enclosure, begin, end;  // places
  };
  std::vector<Chunk> chunks_;                                // of all closed enclosures
  mutable std::vector<Vector3> element_gradient_;            // [slot] dq/dp
  mutable std::vector<double> element_force_;                // [element] Q
  mutable std::vector<Enclosure::Values> enclosure_shares_;  // [chunk]
};

// Threads worth using for a network of this many springs (an element counts as several): one below some thousand, where
// barriers cost more than they bring. `wanted` 0 means as many as the machine has.
[[nodiscard]] unsigned useful_threads(unsigned wanted, std::size_t springs, std::size_t units);

}  // namespace springnet::layers
