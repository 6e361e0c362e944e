// Solves block systems by conjugate gradients, or by BiCGSTAB where the matrix is not symmetric enough, in one region
// of threads. Sums run over chunks of some hundred nodes in a fixed order: the same bits for every number of threads.
//
// Constraints enter through the preconditioner alone: B = Q P^-1 Q^T, with Q the projection onto the changes that they
// allow, answers such changes only and drops constraint forces (Gould, Hribar, Nocedal 2001). Rank-one terms of
// enclosures enter B by the formula of Sherman, Morrison and Woodbury, so that iterations do not depend on how stiff a
// filling is.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Dense>

#include "layers/linear/block_preconditioner.hpp"
#include "layers/linear/coarse_space.hpp"
#include "layers/linear/conjugate_gradients.hpp"
#include "layers/linear/deadline.hpp"
#include "layers/linear/projection.hpp"

namespace springnet::layers {

class IterativeSolver {
 public:
  IterativeSolver(InstructionSet set, unsigned threads)
      : kernels_(block_kernels_for(set)), threads_(threads), coarse_(set) {}

  // Makes a projection with these mobilities, the preconditioner's inverse_blocks(); an empty one without constraints.
  using MakeProjection = std::function<Projection(const std::vector<double>& mobility)>;

  // Sets up the preconditioner. position: where the system was linearised, x, y, z, [node] m.
  void prepare(const BlockSystem& system, BlockPreconditioner::Kind kind, const std::array<const double*, 3>& position,
               const MakeProjection& make_projection);
  // Solves S x = b to `accuracy`: of the norm of M^-1/2 (b - S x), or with constraint rows of the preconditioned
  // residual. Without symmetry it stalls if the norm does not follow the preconditioned residual soon, which it then
  // answers. [node][3] and one more number; b is zero for nodes that do not move.
  [[nodiscard]] SolveAnswer solve(const BlockSystem& system, bool symmetric, double accuracy,
                                  std::uint32_t max_iterations, const std::vector<double>& b, std::vector<double>& x);
  [[nodiscard]] const BlockPreconditioner& preconditioner() const noexcept { return preconditioner_; }

  // Solutions end soon after it, stalled; null: none. It must outlive the solver.
  void set_deadline(const Deadline* deadline) noexcept { interruption_.set_deadline(deadline); }

  // ---- for conjugate_gradients() and bicgstab() ----
  // Vectors are [node][3] and one more number.
  void product(Team& team, const double* p, double* q);
  double product_and_dot(Team& team, const double* p, double* q) {
    product(team, p, q);
    return dot(team, p, q);
  }
  void precondition(Team& team, const double* r, double* z);
  [[nodiscard]] double dot(Team& team, const double* a, const double* b);
  [[nodiscard]] double square(Team& team, const double* r, double along);
  [[nodiscard]] double mass_square(Team& team, const double* r);
  void add(Team& team, double s, const double* x, double* y) { kernels_.add(s, x, nodes_of(team), y); }
  Sums2 update(Team& team, double step, const double* p, const double* q, double* x, double* r, double* z);
  void scale_add(Team& team, double s, const double* x, double* y) { kernels_.scale_add(s, x, nodes_of(team), y); }
  void copy(Team& team, const double* x, double* y);
  void zero(Team& team, double* x);
  [[nodiscard]] bool is_late(const Team& team, std::uint32_t iterations) { return interruption_(team, iterations); }

 private:
  static constexpr std::size_t chunk = 256;  // nodes of a part of a sum
  [[nodiscard]] std::size_t chunk_count() const noexcept { return (nodes_ + chunk - 1) / chunk; }
  [[nodiscard]] NodeRange chunk_nodes(std::size_t index) const noexcept;
  // The calling thread's nodes, whole chunks; or whole pieces of the preconditioner.
  [[nodiscard]] NodeRange nodes_of(const Team& team) const noexcept;
  [[nodiscard]] NodeRange pieces_of(const Team& team) const noexcept;
  SolveAnswer solve_unsymmetric(Team& team, double accuracy, std::uint32_t max_iterations, const double* b, double* x);
  void prepare_terms(const BlockSystem& system);
  void prepare_coarse(const BlockSystem& system, const std::array<const double*, 3>& position);
  void add_coarse(const double* r, double* z);
  void correct(double* z) const;  // for the enclosures

  const BlockKernels& kernels_;
  unsigned threads_;
  const BlockSystem* system_ = nullptr;  // to be solved
  std::size_t nodes_ = 0;
  BlockPreconditioner preconditioner_;
  CoarseSpace coarse_;
  Projection projection_;
  std::vector<double> impulses_;  // projected
  std::vector<double> balanced_;  // forces without what reactions balance
  std::vector<double> inverse_mass_;
  std::vector<std::vector<double>> work_;
  TeamSum sum_;
  Interruption interruption_;
  // B - Z T^-1 G^T B for the enclosures' terms of positive stiffness.
  std::vector<const BlockSystem::RankOne*> terms_;
  std::vector<std::vector<double>> z_;
  Eigen::LDLT<Eigen::MatrixXd> small_;
};

}  // namespace springnet::layers
