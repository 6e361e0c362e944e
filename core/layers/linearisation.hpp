// Derivatives of the accelerations with respect to positions and velocities, from those of the laws and neurons, and
// the linear systems of implicit methods.
#pragma once

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <cstdint>
#include <vector>

#include "layers/evaluator.hpp"

namespace springnet::layers {

// With dp, dv the relative position and velocity of a spring's ends, F the force on its first end:
//   K = -dF/d(dp) = T' n n^T + (T / l)(I - n n^T) + T_u n w^T,   w = (dv - u n) / l
//   D = -dF/d(dv) = T_u n n^T + Q' s s^T + (Q / |dv|)(I - s s^T)
// (T, T', T_u: axial tension and its derivatives with respect to length and rate; Q, Q': force along the relative
// velocity, direction s, and its derivative). Both are the same seen from either end. K is not symmetric where the
// viscosity is axial.
class Linearisation {
 public:
  // References have to outlive it. constrained: [node] 1 where a node is fixed or held: its acceleration is 0.
  Linearisation(const Layout& layout, const Evaluator& evaluator, const std::vector<std::uint8_t>& constrained);

  // Computes all blocks at a state. SPRINGNET_FAILED if a law or neuron has no derivatives.
  springnet_status update(double time, const NodeArrays& nodes, const ExternalForces& external,
                          springnet_message& message);
  // Whether there is a state that the functions below speak of: update() succeeded, no spring was removed since.
  [[nodiscard]] bool known() const noexcept { return known_; }
  // out = da/dp dp + da/dv dv; 3n numbers each, x of all nodes first.
  void times(const double* dp, const double* dv, double* out) const;
  // Diagonal blocks of I - velocity_weight da/dv - position_weight da/dp, [node][9].
  void diagonal_blocks(double velocity_weight, double position_weight, double* out) const;
  springnet_status factorise(double velocity_weight, double position_weight, springnet_message& message);
  springnet_status solve(bool transposed, const double* right_side, double* x, springnet_message& message);
  // To be called after springs were removed.
  void topology_changed() noexcept { pattern_known_ = known_ = false; }

 private:
  using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  using Blocks = std::vector<double>;
  [[nodiscard]] static Eigen::Map<const Block> block(const Blocks& blocks, std::size_t index) {
    return Eigen::Map<const Block>(blocks.data() + 9 * index);
  }
  void make_pattern();

  const Layout& layout_;
  const Evaluator& evaluator_;
  const std::vector<std::uint8_t>& constrained_;
  Blocks stiffness_, damping_;                   // [spring]
  Blocks by_force_, by_position_, by_velocity_;  // [node]
  std::vector<double> force_[3], acceleration_[3];
  bool known_ = false;
  bool pattern_known_ = false;
  Eigen::SparseMatrix<double> matrix_;  // 3n x 3n, unknown 3 node + coordinate
  Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> factors_;
  Eigen::VectorXd work_;
};

}  // namespace springnet::layers
