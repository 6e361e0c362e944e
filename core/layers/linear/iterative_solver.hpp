// Solves block systems by conjugate gradients, or by BiCGSTAB where the matrix is not symmetric enough, in one region
// of threads. Sums run over chunks of some hundred nodes in a fixed order: the same bits for every number of threads.
//
// Constraints enter through the preconditioner alone: B = Q P^-1 Q^T, with Q the projection onto the changes that they
// allow, answers such changes only and drops constraint forces (Gould, Hribar, Nocedal 2001). Rank-one terms of
// enclosures enter B by the formula of Sherman, Morrison and Woodbury, so that iterations do not depend on how stiff a
// filling is.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Dense>

#include "layers/linear/block_preconditioner.hpp"
#include "layers/linear/projection.hpp"

namespace springnet::layers {

class IterativeSolver {
 public:
  IterativeSolver(InstructionSet set, unsigned threads) : kernels_(block_kernels_for(set)), threads_(threads) {}

  enum class Outcome {
    solved,
    // Conjugate gradients met a direction of negative curvature; x is the iterate before, zero if it was the first.
    truncated,
    // Not as accurate as asked for within the iterations, or not at all.
    stalled
  };
  struct Answer {
    Outcome outcome = Outcome::stalled;
    std::uint32_t iterations = 0;
    double residual = 1.0;  // relative to the right-hand side's
  };
  // Makes a projection with these mobilities, the preconditioner's inverse_blocks(); an empty one without constraints.
  using MakeProjection = std::function<Projection(const std::vector<double>& mobility)>;

  // Sets up the preconditioner.
  void prepare(const BlockSystem& system, BlockPreconditioner::Kind kind, const MakeProjection& make_projection);
  // Solves S x = b to `accuracy`: of the norm of M^-1/2 (b - S x), or with constraint rows of the preconditioned
  // residual. [node][3] and one more number; b is zero for nodes that do not move.
  [[nodiscard]] Answer solve(const BlockSystem& system, bool symmetric, double accuracy, std::uint32_t max_iterations,
                             const std::vector<double>& b, std::vector<double>& x);
  [[nodiscard]] const BlockPreconditioner& preconditioner() const noexcept { return preconditioner_; }

 private:
  static constexpr std::size_t chunk = 256;  // nodes
  struct Team;
  Answer conjugate_gradients(Team& team, const BlockSystem& system, double accuracy, std::uint32_t max_iterations,
                             const double* b, double* x);
  Answer bicgstab(Team& team, const BlockSystem& system, double accuracy, std::uint32_t max_iterations, const double* b,
                  double* x);
  // q = S p and z = B r. Complete for all threads' nodes of the calling thread's range; `p` must be complete for all.
  void product(Team& team, const BlockSystem& system, const double* p, double* q);
  void precondition(Team& team, const double* r, double* z);
  // The sum over all nodes of what `part` answers for a range, the same in all threads. A barrier.
  template <class Part>
  double sum(Team& team, const Part& part);
  void prepare_enclosures(const BlockSystem& system);
  void correct(double* z) const;  // for the enclosures

  const BlockKernels& kernels_;
  unsigned threads_;
  std::size_t nodes_ = 0;
  BlockPreconditioner preconditioner_;
  Projection projection_;
  std::vector<double> impulses_;  // projected
  std::vector<double> inverse_mass_;
  std::vector<std::vector<double>> work_;
  std::vector<double> partial_;  // [slot][chunk]
  // B - Z T^-1 G^T B for the enclosures' terms of positive stiffness.
  std::vector<const BlockSystem::RankOne*> terms_;
  std::vector<std::vector<double>> z_;
  Eigen::LDLT<Eigen::MatrixXd> small_;
};

}  // namespace springnet::layers
