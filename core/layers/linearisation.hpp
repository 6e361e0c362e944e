// Derivatives of the accelerations with respect to positions and velocities, from those of the laws and neurons, and
// the linear systems of implicit methods.
#pragma once

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <cstdint>
#include <utility>
#include <vector>

#include "layers/constraint_row.hpp"
#include "layers/element_linearisation.hpp"
#include "layers/evaluator.hpp"
#include "layers/low_rank.hpp"
#include "layers/spring_blocks.hpp"

namespace springnet::layers {

// The blocks of springs are those of spring_blocks.hpp, those of elements of element_linearisation.hpp. What a closed
// surface does to all of its nodes at once is no part of the sparse matrix: it would fill it.
class Linearisation {
 public:
  // References have to outlive it. constrained: [node] 1 where a node is fixed or held: its acceleration is 0.
  Linearisation(const Layout& layout, const Evaluator& evaluator, const std::vector<std::uint8_t>& constrained);

  // Computes all blocks at a state. SPRINGNET_FAILED if a law or neuron has no derivatives, SPRINGNET_RECOVERABLE if
  // the answer of one is not finite there; the message says which, and for which spring, element or node.
  springnet_status update(double time, const NodeArrays& nodes, const ExternalForces& external,
                          springnet_message& message);
  // Adds to da/dv of one node, 1/s, after update().
  void add_to_velocity_block(std::uint32_t node, const Block& block) {
    Eigen::Map<Block>(by_velocity_.data() + 9 * std::size_t{node}) += block;
  }
  // Adds the stiffness (N/m) of a force between two nodes that are neighbours, after update().
  void add_bond(std::uint32_t first, std::uint32_t second, const Block& stiffness) {
    bonds_.push_back({first, second, stiffness});
  }
  // Whether there is a state that the functions below speak of: update() succeeded, no spring was removed since.
  [[nodiscard]] bool known() const noexcept { return known_; }
  // out = da/dp dp + da/dv dv; 3n numbers each, x of all nodes first.
  void times(const double* dp, const double* dv, double* out);
  // Diagonal blocks of I - velocity_weight da/dv - position_weight da/dp, [node][9].
  void diagonal_blocks(double velocity_weight, double position_weight, double* out) const;
  // A = I - velocity_weight da/dv - position_weight da/dp as a sparse matrix, unknown 3 node + coordinate; without what
  // closed surfaces do to all of their nodes. Valid until the next call of a function that is not const.
  [[nodiscard]] const Eigen::SparseMatrix<double>& matrix(double velocity_weight, double position_weight);

  // Whether no neuron by itself feeds a motion: its da/dp and da/dv are diagonal and nowhere above 0.
  [[nodiscard]] bool neurons_dissipate() const;

  // ---- node by node, for sweeps ----
  // Weighs the blocks for others_of().
  void weigh(double velocity_weight, double position_weight);
  // (velocity_weight da/dv + position_weight da/dp) u of a node, without its own block; u: [3] components, [node].
  // Closed surfaces: follow() first, and moved() after every change of u.
  [[nodiscard]] Vector3 others_of(std::uint32_t node, const double* const u[3]) const;
  void follow(const double* const u[3]) { elements_.follow(u); }
  void moved(std::uint32_t node, const Vector3& change) { elements_.moved(node, change); }

  // Of A = I - velocity_weight da/dv - position_weight da/dp, and, where `rows` bind the motion, of
  //   [A  W G^T; G  0], G the rows, W the derivatives of the accelerations with respect to forces.
  springnet_status factorise(double velocity_weight, double position_weight, const std::vector<ConstraintRow>& rows,
                             springnet_message& message);
  // A x = b; with rows the x for which A x + W G^T (multipliers) = b and G x = G b.
  springnet_status solve(bool transposed, const double* right_side, double* x, springnet_message& message);
  // To be called after springs or elements were removed.
  void topology_changed() noexcept {
    pattern_known_ = known_ = bordered_known_ = false;
    elements_.topology_changed();
  }

 private:
  using Blocks = std::vector<double>;
  struct Bond {
    std::uint32_t first, second;
    Block stiffness;
  };
  [[nodiscard]] static Eigen::Map<const Block> block(const Blocks& blocks, std::size_t index) {
    return Eigen::Map<const Block>(blocks.data() + 9 * index);
  }
  // What to say of a law whose answer at this state was not finite.
  springnet_status not_finite(double time, const NodeArrays& nodes, springnet_message& message) const;
  // SPRINGNET_RECOVERABLE with a message where what neurons answered is not finite.
  springnet_status check_neurons(springnet_message& message) const;
  void make_pattern();
  // vectors: with what closed surfaces do to all of their nodes.
  void diagonal_blocks(double velocity_weight, double position_weight, bool vectors, double* out) const;
  // Of the factorised matrix without closed surfaces.
  [[nodiscard]] LowRank::Solve plain_solver();
  // Of the factorised matrix and right sides of its size.
  [[nodiscard]] Eigen::VectorXd solve_factorised(bool transposed, const Eigen::VectorXd& right_side);
  void set_vectors(double velocity_weight, double position_weight);
  void factorise_bound(const std::vector<ConstraintRow>& rows);

  const Layout& layout_;
  const Evaluator& evaluator_;
  const std::vector<std::uint8_t>& constrained_;
  Blocks stiffness_, damping_;                   // [spring]
  Blocks by_force_, by_position_, by_velocity_;  // [node]
  std::vector<Bond> bonds_;
  Blocks weighted_;                                                 // [spring], of weigh()
  std::vector<std::pair<std::uint32_t, std::uint32_t>> bond_ends_;  // node and bond, sorted, likewise
  double weighed_position_ = 0.0;
  ElementLinearisation elements_;
  LowRank vectors_;  // of closed surfaces, as factorised
  std::vector<double> force_[3], acceleration_[3];
  bool known_ = false;
  bool pattern_known_ = false;
  Eigen::SparseMatrix<double> matrix_;  // 3n x 3n, unknown 3 node + coordinate
  Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> factors_;
  // With rows: the same matrix bordered by them.
  std::vector<ConstraintRow> rows_;
  Eigen::SparseMatrix<double> bordered_;
  bool bordered_known_ = false;  // its pattern
  Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> bordered_factors_;
  Eigen::VectorXd work_;
};

}  // namespace springnet::layers
