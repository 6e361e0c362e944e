// Derivatives of the accelerations with respect to positions and velocities, from those of the laws and neurons, and
// the linear systems of implicit methods.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "layers/evaluator.hpp"
#include "layers/linear/constraint_row.hpp"
#include "layers/linear/element_linearisation.hpp"
#include "layers/linear/low_rank.hpp"
#include "layers/springs/blocks.hpp"

namespace springnet::layers {

class AxialSprings;

// Blocks of springs are kept one each (springs/blocks.hpp), those of elements summed (element_linearisation.hpp). The
// rank-one terms of enclosures stay out of the sparse matrix, which they would fill. Where all laws of springs are
// axial, their blocks are computed when they are first asked for: products, also transposed, do without.
class Linearisation {
 public:
  // References must outlive it. constrained: [node] 1 where a node is fixed or held, so that its acceleration is 0.
  Linearisation(const Layout& layout, const Evaluator& evaluator, const std::vector<std::uint8_t>& constrained);
  ~Linearisation();
  Linearisation(const Linearisation&) = delete;
  Linearisation& operator=(const Linearisation&) = delete;

  // Computes all blocks at a state. SPRINGNET_FAILED if a law or neuron has no derivatives, SPRINGNET_RECOVERABLE if
  // one answers a number that is not finite; the message names it, and the spring, element or node.
  springnet_status update(double time, const NodeArrays& nodes, const ExternalForces& external,
                          springnet_message& message);
  // Adds to the da/dv block of one node, 1/s; call after update().
  void add_to_velocity_block(std::uint32_t node, const Block& block) {
    Eigen::Map<Block>(by_velocity_.data() + 9 * std::size_t{node}) += block;
    scales_.clear();
  }
  // Adds to the da/dp block of one node, 1/s^2; call after update().
  void add_to_position_block(std::uint32_t node, const Block& block) {
    Eigen::Map<Block>(by_position_.data() + 9 * std::size_t{node}) += block;
    scales_.clear();
  }
  // Adds a stiffness (N/m) between two neighbours; call after update().
  void add_bond(std::uint32_t first, std::uint32_t second, const Block& stiffness) {
    bonds_.push_back({first, second, stiffness});
  }
  // Adds what opposes the rate of a row with this damping (N s/m) on its nodes, which need not be neighbours; call
  // after update().
  void add_drag(const ConstraintRow& row, double damping) { drags_.push_back({row, damping}); }
  struct Drag {
    ConstraintRow row;
    double damping;  // N s/m
  };
  [[nodiscard]] const std::vector<Drag>& drags() const noexcept { return drags_; }
  // Whether update() succeeded and nothing was removed since: the functions below need it.
  [[nodiscard]] bool known() const noexcept { return known_; }
  // out = da/dp dp + da/dv dv; 3n numbers each, x of all nodes first.
  void times(const double* dp, const double* dv, double* out);
  // by_position = (da/dp)^T weights, by_velocity = (da/dv)^T weights; arrays as above.
  void transposed_times(const double* weights, double* by_position, double* by_velocity);
  // out = velocity_weight (da/dv)^T weights + position_weight (da/dp)^T weights, in less time than both.
  void weighted_transposed_times(double velocity_weight, double position_weight, const double* weights, double* out);
  // out = (da/dF)^T weights, 0 for nodes that are fixed or held.
  void force_weights(const double* weights, double* out) const;
  // out = da/dF force, with forces on nodes, N; arrays as above.
  void accelerations(const double* force, double* out) const;
  // Diagonal blocks of I - velocity_weight da/dv - position_weight da/dp, [node][9].
  void diagonal_blocks(double velocity_weight, double position_weight, double* out);
  // The entries of A = I - velocity_weight da/dv - position_weight da/dp, unknown 3 node + coordinate, without the
  // rank-one terms of enclosures and drags.
  void for_each_entry(double velocity_weight, double position_weight,
                      const std::function<void(int row, int column, double value)>& visit);

  // ---- its parts, after update() ----
  // To be called before weighted().
  void need_spring_blocks();
  // velocity_weight (-dF/dv) + position_weight (-dF/dp) of a spring: force on its first end by that end's motion.
  [[nodiscard]] Block weighted(std::uint32_t spring, double velocity_weight, double position_weight) const {
    return velocity_weight * block(damping_, spring) + position_weight * block(stiffness_, spring);
  }
  // Of a node's neuron: da/dF (1/kg), da/dv (1/s, with the friction of add_to_velocity_block), da/dp (1/s^2).
  [[nodiscard]] Eigen::Map<const Block> by_force(std::uint32_t node) const { return block(by_force_, node); }
  [[nodiscard]] Eigen::Map<const Block> by_velocity(std::uint32_t node) const { return block(by_velocity_, node); }
  [[nodiscard]] Eigen::Map<const Block> by_position(std::uint32_t node) const { return block(by_position_, node); }
  [[nodiscard]] const ElementLinearisation& elements() const noexcept { return elements_; }
  struct Bond {
    std::uint32_t first, second;
    Block stiffness;
  };
  [[nodiscard]] const std::vector<Bond>& bonds() const noexcept { return bonds_; }

  // Whether no neuron by itself feeds a motion: its da/dp and da/dv are diagonal and nowhere above 0.
  [[nodiscard]] bool neurons_dissipate() const;

  // ---- node by node, for sweeps ----
  // Sets the weights of off_diagonal_product().
  void set_weights(double velocity_weight, double position_weight);
  // (velocity_weight da/dv + position_weight da/dp) u of a node, without its own block; u: [3] components, [node].
  // Enclosures: track() first, and add_change() after every change of u.
  [[nodiscard]] Vector3 off_diagonal_product(std::uint32_t node, const double* const u[3]) const;
  void track(const double* const u[3]) { elements_.track(u); }
  void add_change(std::uint32_t node, const Vector3& change) { elements_.add_change(node, change); }

  // Factorises A = I - velocity_weight da/dv - position_weight da/dp or, if there are constraint rows,
  //   [A  W G^T; G  0], G the rows, W the derivatives of the accelerations with respect to forces.
  // SPRINGNET_RECOVERABLE if the matrix is singular.
  springnet_status factorise(double velocity_weight, double position_weight, const std::vector<ConstraintRow>& rows,
                             springnet_message& message);
  // A x = b; with rows the x for which A x + W G^T (multipliers) = b and G x = G b.
  springnet_status solve(bool transposed, const double* right_side, double* x, springnet_message& message);
  // Call it after springs or elements were removed.
  void topology_changed() noexcept {
    pattern_known_ = known_ = bordered_known_ = false;
    elements_.topology_changed();
  }

 private:
  using Blocks = std::vector<double>;
  struct System;  // sparse matrices and their factors: Eigen's templates for them are compiled in one file only
  [[nodiscard]] static Eigen::Map<const Block> block(const Blocks& blocks, std::size_t index) {
    return Eigen::Map<const Block>(blocks.data() + 9 * index);
  }
  // SPRINGNET_RECOVERABLE with a message that says which law's answer is not finite.
  springnet_status not_finite(double time, const NodeArrays& nodes, springnet_message& message) const;
  // SPRINGNET_RECOVERABLE with a message if a neuron's answer is not finite.
  springnet_status check_neurons(springnet_message& message) const;
  void make_pattern();
  // What neurons, elements and bonds add to transposed products at force_weights_: add(node, by_position, by_velocity).
  template <class Add>
  void add_transposed_beside_springs(const double* weights, const Add& add);
  void find_scales();
  void spread_force_weights();
  // Writes A into the sparse matrix.
  void fill(double velocity_weight, double position_weight);
  // vectors: with the rank-one terms of enclosures.
  void diagonal_blocks(double velocity_weight, double position_weight, bool vectors, double* out) const;
  // use(node, weight): of nodes of a drag that can move.
  template <class Use>
  void for_each_dragged(const Drag& drag, const Use& use) const {
    drag.row.for_each_end([&](std::size_t, std::uint32_t node, double weight) {
      if (constrained_[node] == 0) use(node, weight);
    });
  }
  // Solver of the factorised matrix without the rank-one terms.
  [[nodiscard]] LowRank::Solve plain_solver();
  // Solution with the rank-one terms; right_side has the size of the factorised matrix.
  [[nodiscard]] Eigen::VectorXd solve_factorised(bool transposed, const Eigen::VectorXd& right_side);
  void set_vectors(double velocity_weight, double position_weight);
  void factorise_bound(const std::vector<ConstraintRow>& rows);

  const Layout& layout_;
  const Evaluator& evaluator_;
  const std::vector<std::uint8_t>& constrained_;
  Blocks stiffness_, damping_;  // [spring]
  std::unique_ptr<AxialSprings> axial_;
  bool are_axial_ = false;                       // all springs are known to axial_,
  bool has_blocks_ = false;                      // and to stiffness_ and damping_
  std::vector<double> four_;                     // [3][node][4], of products
  Blocks by_force_, by_position_, by_velocity_;  // [node]
  // Where all of these are multiples of the identity: [node][3], of each kind one. Empty: they are not.
  std::vector<double> scales_;
  std::vector<Bond> bonds_;
  std::vector<Drag> drags_;
  Blocks weighted_;                                                 // [spring], of set_weights()
  std::vector<std::pair<std::uint32_t, std::uint32_t>> bond_ends_;  // node and bond, sorted, likewise
  double position_weight_ = 0.0;
  ElementLinearisation elements_;
  LowRank vectors_;  // rank-one terms of enclosures and drags, as of the last factorisation
  std::vector<double> force_[3], acceleration_[3];
  std::vector<double> force_weights_;  // [3 node], of transposed_times
  bool known_ = false;
  bool pattern_known_ = false;
  std::unique_ptr<System> system_;
  std::vector<ConstraintRow> rows_;
  bool bordered_known_ = false;  // the pattern of the matrix with rows
  Eigen::VectorXd work_;
};

}  // namespace springnet::layers
