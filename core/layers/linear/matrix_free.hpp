// The system of an implicit step of a large net of springs alone, without its matrix: products go over the springs,
// four numbers each, ordered by their first nodes; the preconditioner inverts the nodes' own blocks, and those of
// groups of nodes of stiff nets. Nets with elements or rigid connections, neurons other than point masses with drag,
// and springs that soften need the assembled block system.
//
// The matrix is the symmetric part of the exact one. With tension T at length l, direction n and weights w_p, w_v of
// position and velocity, a spring has
//   w_p K + w_v D = a I + q q^T,   a = w_p T / l,   q = n sqrt(w_p (T' - T / l) + w_v T_u),
// without the part T_u n w^T of K, which only its relative size tells: asymmetry().
//
// Conjugate gradients, or with friction BiCGSTAB, run in single precision, in units in which masses and right-hand side
// are about 1. Solutions more accurate than that allows are refined: residuals in double precision are solved for
// again.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "layers/evaluator.hpp"
#include "layers/linear/axial_segments.hpp"
#include "layers/linear/block_system.hpp"
#include "layers/linear/coarse_space.hpp"
#include "layers/linear/coarse_use.hpp"
#include "layers/linear/conjugate_gradients.hpp"
#include "layers/linear/deadline.hpp"
#include "layers/linear/node_response.hpp"
#include "layers/linear/spring_kernels.hpp"
#include "layers/linear/spring_order.hpp"

namespace springnet::layers {

class MatrixFree {
 public:
  // References must outlive it. mass: [node] kg; constrained: [node] 1 for nodes that do not move.
  MatrixFree(const Layout& layout, const Evaluator& evaluator, const std::vector<double>& mass,
             const std::vector<std::uint8_t>& constrained);

  // Whether the net is of this kind, and large enough; depends on its springs that are left.
  [[nodiscard]] bool fits() const;
  // Linearises at a state. responses: of nodes on surfaces. False if a spring, law or neuron does not allow it; nothing
  // is kept then.
  [[nodiscard]] bool prepare(double time, const NodeArrays& nodes, const ExternalForces& external,
                             const SystemWeights& weights, const std::vector<NodeResponse>& responses);
  [[nodiscard]] double asymmetry() const noexcept { return asymmetry_; }
  // Solves S x = M b, with responses x = C K x + b; [3 node], x of all nodes first. Reads b as 0 for nodes that do not
  // move. Accuracy is of the norm of M^-1/2 (M b - S x); with friction, up to what single precision reaches, of the
  // preconditioned residual.
  [[nodiscard]] SolveAnswer solve(double accuracy, std::uint32_t max_iterations, const double* b, double* x);

  // Drops what is kept for the next systems.
  void forget() noexcept {
    coarse_.clear();
    last_weights_.reset();
  }
  // Whether the preconditioner of the present system has parts of an earlier one; then makes those anew, for a solution
  // that has stalled. position: that of prepare(), x, y, z, [node] m.
  [[nodiscard]] bool renews(const std::array<const double*, 3>& position);
  // Solutions end soon after it, stalled; null: none. It must outlive the solver.
  void set_deadline(const Deadline* deadline) noexcept { interruption_.set_deadline(deadline); }

  // ---- for conjugate_gradients() and bicgstab() ----
  // Vectors are [node][4]: x, y, z and 0.
  double product_and_dot(Team& team, const float* p, float* q);
  void precondition(Team& team, const float* r, float* z);
  [[nodiscard]] double dot(Team& team, const float* a, const float* b);
  void product(Team& team, const float* p, float* q);
  void add(Team& team, double s, const float* x, float* y);
  [[nodiscard]] double square(Team& team, const float* r, double along);
  [[nodiscard]] double mass_square(Team& team, const float* r);
  Sums2 update(Team& team, double step, const float* p, const float* q, float* x, float* r, float* z);
  void scale_add(Team& team, double s, const float* x, float* y);
  void copy(Team& team, const float* x, float* y);
  void zero(Team& team, float* x);
  [[nodiscard]] bool is_late(const Team& team, std::uint32_t iterations) { return interruption_(team, iterations); }

 private:
  // Of the springs of a unit, those within before those that leave: [spring][4].
  struct Springs {
    std::vector<float> stiffness;
    std::size_t within = 0;  // how many
  };
  void lay_out();
  [[nodiscard]] SpringRows rows_within(std::size_t unit) const;
  [[nodiscard]] SpringRows rows_leaving(std::size_t unit) const;
  void take_incoming(std::size_t unit);
  // Keeps that of an earlier system while it serves.
  void prepare_coarse(const NodeArrays& nodes, const SystemWeights& weights);
  void make_coarse(const std::array<const double*, 3>& position);
  // Adds the coarse correction to z = D r; answers r times it.
  double correct(Team& team, const float* r, float* z);
  // Of a unit's nodes: blocks_ with their springs', and their inverses. False: one is not positive definite.
  [[nodiscard]] bool invert_blocks(std::size_t unit);
  void set_inverse(std::size_t node, const Eigen::Matrix3d& inverse);
  // The responses' parts of own_, blocks_ and inverses. False: one has none.
  [[nodiscard]] bool add_responses();
  // Their parts of own_ and blocks_ alone, times a share.
  void add_additions(double share);
  // In single precision: vectors_[1] of vectors_[0].
  SolveAnswer solve_once(Team& team, double accuracy, std::uint32_t max_iterations);
  // In one thread of the team.
  SolveAnswer solve(Team& team, double accuracy, std::uint32_t max_iterations, const double* b);
  // residual_ = right_side_ - S solution_; answers its norm.
  double find_residual(Team& team);
  [[nodiscard]] double norm(Team& team, const double* residual);
  StiffnessSums linearise_unit(std::size_t unit, double time, const NodeArrays& nodes, const SystemWeights& weights);
  // Whether springs that do not fit all join nodes that do not move; they are left out then.
  [[nodiscard]] bool fits_where_it_matters(const AxialAnswers& answers, float* stiffness) const;
  [[nodiscard]] bool set_own_blocks(double time, const NodeArrays& nodes, const ExternalForces& external,
                                    const SystemWeights& weights);
  // The calling thread's units, their parts and their nodes.
  [[nodiscard]] NodeRange own_units(const Team& team) const;
  [[nodiscard]] NodeRange own_parts(const Team& team) const;
  [[nodiscard]] NodeRange own_nodes(const Team& team) const;

  const Layout& layout_;
  const Evaluator& evaluator_;
  const std::vector<double>& mass_;
  const std::vector<std::uint8_t>& constrained_;
  SpringOrder springs_;
  AxialSegments segments_;
  bool is_laid_out_ = false;  // what depends on that order
  const SpringKernels& kernels_;
  std::vector<Springs> of_unit_;         // [unit]
  std::vector<NodeRange> parts_;         // of sums
  std::vector<std::size_t> first_part_;  // [unit + 1]
  double unit_ = 1.0;                    // kg: the system is that in this unit of mass
  std::vector<double> own_;              // [node][3][4] columns of their own blocks
  std::vector<double> blocks_;           // [node][3][3], with the springs'
  std::vector<double> spring_blocks_;    // [node][8] of these, see SpringKernels::add_blocks
  std::vector<float> inverse_;           // [node][3][4] columns
  bool isotropic_ = false;               // own_ are multiples of the identity:
  std::vector<float> own_scale_;         // [node]
  std::vector<float> own_single_;        // own_, if they are not
  std::vector<float> inverse_mass_;      // [node]
  CoarseSpace coarse_;
  double coarse_part_ = 0.0;
  CoarseUse coarse_use_;
  bool coarse_is_kept_ = false;
  std::optional<SystemWeights> last_weights_;  // of the system before
  bool repeats_ = true;                        // the weights of the system before
  double coarse_unit_ = 0.0;                   // kg, in which it is
  double velocity_weight_ = 0.0;               // s
  std::vector<float> mass_in_unit_;            // [node]
  NodeResponses responses_;
  std::array<std::vector<float>, 8> vectors_;             // b, x, and of work; the last two for BiCGSTAB alone
  std::vector<double> solution_, residual_, right_side_;  // [node][4], of M b in the unit of mass
  std::vector<double> force_;
  std::vector<double> by_force_, by_position_, by_velocity_;
  TeamSum sum_;
  Interruption interruption_;
  double asymmetry_ = 0.0;
};

}  // namespace springnet::layers
