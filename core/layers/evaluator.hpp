// Evaluates the spring layer, the elements and the node layer: from positions and velocities to net forces and
// accelerations. What springs do is in springs/, what elements do in elements/.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "layers/elements/enclosure_volumes.hpp"
#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"
#include "layers/springs/node_springs.hpp"

namespace springnet::layers {

// Forces of neither springs nor elements.
struct ExternalForces {
  Vector3 gravity = Vector3::Zero();  // m/s^2
  ForceArrays loads{};                // N, [node]; null for none
  const double* pressure = nullptr;   // Pa, [load]: following pressures; null for none
};

// Called once the net forces of a tile, nodes [first, first + count), are final, by the thread that computed them:
// force[i] is that on node first + i, N. A status other than SPRINGNET_OK ends the evaluation, as that of a law does.
struct TileFinished {
  springnet_status (*call)(void* user, std::uint32_t unit, std::uint32_t first, std::uint32_t count,
                           const ForceArrays& force, springnet_message& message) = nullptr;
  void* user = nullptr;
};

// Derivatives of a node's acceleration with respect to its own velocity and position; row-major.
struct NodeDerivatives {
  double by_velocity[9];  // da/dv, 1/s
  double by_position[9];  // da/dp, 1/s^2
};

// Derivatives of accelerations by what neurons read besides force, position and velocity: [node][3] each, or null.
struct NeuronScalars {
  double* by_mass = nullptr;               // m/(s^2 kg)
  double* by_time = nullptr;               // m/s^3
  double* const* by_parameters = nullptr;  // [max_parameters], each may be null
};

// Up to together_limit nodes to evaluate together, node by node.
struct NodeList {
  std::span<const std::uint32_t> nodes;
  std::span<const NodeSprings> springs{};  // theirs, if they are at hand; else they are found
};

// The values of nodes of a list, side by side.
struct ListedNodes {
  alignas(64) double p[3][together_limit];  // m
  double v[3][together_limit];              // m/s
  double mass[together_limit];              // kg
};

struct UnitScratch;

class Evaluator {
 public:
  // Layout and masses ([node] kg) must outlive the evaluator.
  Evaluator(const Layout& layout, const std::vector<double>& mass, InstructionSet set, unsigned threads);
  ~Evaluator();
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  [[nodiscard]] InstructionSet instruction_set() const noexcept { return set_; }
  [[nodiscard]] unsigned threads() const noexcept { return threads_; }

  // Net force on every node, in N, unit by unit on several threads; the order of the sums does not depend on their
  // number. force: null where only `finished` asks for them. Returns the status of the first unit in which a law
  // failed. Throws std::bad_alloc, only at the first call for a layout. Not reentrant: uses buffers of the evaluator.
  springnet_status evaluate(double time, const NodeArrays& nodes, const ExternalForces& external,
                            const ForceArrays& force, TileFinished finished, springnet_message& message) const;
  // Whether all numbers of three arrays are.
  [[nodiscard]] bool all_finite(const double* const values[3], std::size_t count) const noexcept {
    return kernels_.all_finite(values[0], values[1], values[2], count);
  }
  // The values of up to together_limit nodes.
  void copy(std::span<const std::uint32_t> list, const NodeArrays& nodes, ListedNodes& out) const noexcept;
  // Net forces on nodes of a list, whose values are `own`, N: force[component][i] of nodes[i], from all its springs and
  // elements. The same bits whichever nodes are evaluated together. volumes: those of the enclosures at this state;
  // null computes them here, from all their nodes.
  springnet_status evaluate_together(const NodeList& list, const ListedNodes& own, double time, const NodeArrays& nodes,
                                     const ExternalForces& external, const EnclosureVolumes* volumes,
                                     double* const force[3], springnet_message& message) const;
  // The same for one node.
  springnet_status evaluate_node(std::uint32_t node, double time, const NodeArrays& nodes,
                                 const ExternalForces& external, const EnclosureVolumes* volumes, Vector3& force,
                                 springnet_message& message) const;
  // The same with the acceleration that the node's neuron answers, and, where the pointers are not null, its
  // derivatives and the node's potential energy in J: that of its springs and elements minus the work of gravity and
  // loads; nan where there is no potential (a law without energy or that reads the rate, a neuron other than force over
  // mass). SPRINGNET_FAILED if derivatives are wanted and a law or the neuron has none.
  springnet_status evaluate_node(std::uint32_t node, double time, const NodeArrays& nodes,
                                 const ExternalForces& external, const EnclosureVolumes* volumes, Vector3& force,
                                 Vector3& acceleration, NodeDerivatives* derivatives, double* energy,
                                 springnet_message& message) const;
  // Accelerations of nodes [first, first + count), answered by their neurons, m/s^2. `force` and `acceleration` are
  // [count] arrays; the derivative blocks, [count][9], may be null.
  springnet_status accelerations(std::uint32_t first, std::uint32_t count, double time, const NodeArrays& nodes,
                                 const double* const force[3], double* const acceleration[3], double* by_force,
                                 double* by_position, double* by_velocity, springnet_message& message) const {
    return accelerations(first, count, time, nodes, force, acceleration, by_force, by_position, by_velocity, {},
                         message);
  }
  // The same with further derivatives, of neurons that have them.
  springnet_status accelerations(std::uint32_t first, std::uint32_t count, double time, const NodeArrays& nodes,
                                 const double* const force[3], double* const acceleration[3], double* by_force,
                                 double* by_position, double* by_velocity, const NeuronScalars& scalars,
                                 springnet_message& message) const;
  // The same for nodes of a list, whose values are `own`: [component][i] of nodes[i].
  springnet_status accelerations(std::span<const std::uint32_t> list, const ListedNodes& own, double time,
                                 const double* const force[3], double* const acceleration[3],
                                 springnet_message& message) const;

 private:
  // One call of evaluate().
  struct Pass {
    double time;
    const NodeArrays& nodes;
    const ExternalForces& external;
    const ForceArrays& force;
    const TileFinished& finished;
  };
  void prepare_units() const;
  [[nodiscard]] bool take_unit(unsigned thread, std::uint32_t& unit) const noexcept;
  springnet_status evaluate_unit(std::uint32_t unit, const Pass& pass, UnitScratch& scratch,
                                 springnet_message& message) const;
  void begin_forces(std::uint32_t begin, std::uint32_t end, const Pass& pass, const ForceArrays& force,
                    std::uint32_t origin) const;
  springnet_status evaluate_tile(const Unit& unit, const Tile& tile, const Pass& pass, UnitScratch& scratch,
                                 springnet_message& message) const;
  // A tile whose forces are final, but for springs of the unit before.
  springnet_status end_tile(std::uint32_t unit, const Tile& tile, bool waits, const Pass& pass, UnitScratch& scratch,
                            springnet_message& message) const;
  springnet_status finish_tile(std::uint32_t unit, const Tile& tile, const Pass& pass, const ForceArrays& force,
                               springnet_message& message) const;
  [[nodiscard]] std::uint32_t head_end(std::uint32_t unit) const noexcept;
  [[nodiscard]] std::uint32_t head_size(std::uint32_t unit) const noexcept;
  springnet_status arrive_at(std::uint32_t index, const Pass& pass, springnet_message& message) const;
  // Forces of chunks: the pending ones of a segment, the sums over those of a tile.
  void settle_pending(const Unit& unit, UnitScratch& scratch) const noexcept;
  void sum_up(const Unit& unit, UnitScratch& scratch) const noexcept;
  void clear_forces(const Unit& unit, const Segment& segment, UnitScratch& scratch) const noexcept;
  void find_geometry(const Unit& unit, const Segment& segment, const NodeArrays& nodes,
                     UnitScratch& scratch) const noexcept;
  springnet_status apply_laws(const Unit& unit, const Segment& segment, double time, const NodeArrays& nodes,
                              UnitScratch& scratch, springnet_message& message) const;

  // Values, rates and gradients of up to element_batch elements of one invariant.
  void measure(Invariant invariant, const BatchCorners& corners, const NodeArrays& nodes,
               BatchGeometry& out) const noexcept;
  // Forces of every element on its corners; add_elements() sums them up over the elements of each node.
  springnet_status evaluate_elements(double time, const NodeArrays& nodes, springnet_message& message) const;
  springnet_status evaluate_batch(const ElementBatch& batch, double time, const NodeArrays& nodes,
                                  springnet_message& message) const;
  springnet_status evaluate_enclosures(double time, const NodeArrays& nodes, springnet_message& message) const;
  // force: arrays that begin at node `origin`.
  void add_elements(std::uint32_t begin, std::uint32_t end, const ForceArrays& force,
                    std::uint32_t origin) const noexcept;

  struct NodeSums;
  springnet_status add_springs_of(std::uint32_t node, double time, const NodeArrays& nodes, NodeSums& sums,
                                  springnet_message& message) const;
  springnet_status add_springs_of(const NodeList& list, const ListedNodes& own, double time, const NodeArrays& nodes,
                                  double* const force[3], springnet_message& message) const;
  // A batch of springs of nodes of a list: adds its forces.
  springnet_status add_springs(const NodeList& list, const NodeSprings& springs, const ListedNodes& own, double time,
                               const NodeArrays& nodes, double* const force[3], springnet_message& message) const;
  springnet_status call_neuron(const NeuronKind& kind, springnet_neuron_batch& batch, std::uint32_t node,
                               springnet_message& message) const;
  springnet_status add_elements_of(std::uint32_t node, double time, const NodeArrays& nodes,
                                   const EnclosureVolumes* volumes, NodeSums& sums, springnet_message& message) const;
  // Of up to several_batch elements of one group whose laws read several scalars.
  springnet_status add_several_of(std::span<const ElementShare> shares, double time, const NodeArrays& nodes,
                                  NodeSums& sums, springnet_message& message) const;
  springnet_status evaluate_several_batch(const ElementBatch& batch, double time, const NodeArrays& nodes,
                                          springnet_message& message) const;

  const Layout& layout_;
  const std::vector<double>& mass_;
  InstructionSet set_;
  const Kernels& kernels_;
  unsigned threads_;
  // Units on their way; made anew for a revision of the layout.
  struct Share;
  mutable std::uint64_t revision_ = 0;
  mutable std::vector<std::unique_ptr<UnitScratch>> scratch_;      // [thread]
  mutable std::unique_ptr<Share[]> shares_;                        // [thread]
  mutable std::unique_ptr<std::atomic<std::uint8_t>[]> arrivals_;  // [unit]
  mutable std::vector<double> halo_memory_;                        // N
  // [unit] forces of its springs on the first nodes of the next one; those on the head of a unit that waits.
  mutable std::vector<ForceArrays> halo_, head_;
  // Buffers of elements, written and read within one call.
  struct Chunk {
    std::uint32_t enclosure, begin, end;  // places
  };
  std::vector<Chunk> chunks_;                                     // of all closed enclosures
  mutable std::vector<double> corner_force_[3];                   // N, x, y, z: [corner][batched element]
  mutable std::vector<std::vector<Vector3>> enclosure_gradient_;  // [enclosure][place] dq/dp
  mutable std::vector<double> enclosure_force_;                   // [enclosure] Q
  mutable std::vector<Enclosure::Values> enclosure_shares_;       // [chunk]
};

// Number of threads worth using for this many springs (an element counts as several): 1 below some thousands, where
// barriers cost more than threads save. `wanted` 0 stands for as many as the machine has.
[[nodiscard]] unsigned useful_threads(unsigned wanted, std::size_t springs, std::size_t units);

}  // namespace springnet::layers
