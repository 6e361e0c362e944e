// Linear systems of a time step, A = I - w da/dv - w^2 da/dp, and their transposes, at the state last prepared; with
// constraints A = I - w (da/dv U' + da/dp P'), where P' and U' tell how outputs follow the velocities without them.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <springnet/sdk/host.hpp>

#include "learning/constrained_outputs.hpp"
#include "simulation/engine.hpp"

namespace springnet::learning {

// GMRES, of short steps without a preconditioner: where sweeps of the network settle, so does it. Else flexible GMRES
// (Saad, SIAM J. Sci. Comput. 14, 1993), preconditioned by the host's own solver of the step: it solves
// A x = b, and A^T y = b as y = M x with A x = M^-1 b, exactly where M A is symmetric, as of nets with potentials and
// damping along relative velocities. Other damping leaves a few iterations. With C the outputs of nodes on surfaces,
// and A = I - K C, it solves y = C K y + C b, which gives x = K y + b; and x = C^T K x + b, for b in the range of C^T;
// what accelerations of the next step's start have outside of it is left to the iteration. Vectors have 3 node numbers,
// x of all nodes first.
class StepSolver {
 public:
  // The host is the engine's.
  StepSolver(Engine& engine, sdk::Host host) noexcept : linear_(engine.linear()), host_(host) {}

  // Forgets what was found of earlier steps, so that what follows depends on the steps to come alone.
  void begin() noexcept;

  // w: s. Linearises at a state; then the host's jacobian_times and its transpose are those of this state. solutions:
  // how many are to come; a small net is then factorised if that pays. outputs: of a step with constraints, until the
  // next call; the host's accelerations must be those without. Null: there are none.
  void prepare(const springnet_evaluation& at, double w, Eigen::Index solutions = 1,
               const ConstrainedOutputs* outputs = nullptr);
  // accuracy: of the residual, relative to the right-hand side. Throws sdk::Failure if the matrix is singular, or if
  // the iteration does not converge.
  void solve(const Eigen::VectorXd& right_side, double accuracy, Eigen::VectorXd& x);
  // x: a guess when it is called. by_position, by_velocity: (da/dp)^T x and (da/dv)^T x.
  void solve_transposed(const Eigen::VectorXd& right_side, double accuracy, Eigen::VectorXd& x,
                        Eigen::VectorXd& by_position, Eigen::VectorXd& by_velocity);

 private:
  using Map = std::function<void(const Eigen::VectorXd& in, Eigen::VectorXd& out)>;
  using Preconditioner = std::function<void(const Eigen::VectorXd& in, double accuracy, Eigen::VectorXd& out)>;
  // allowed: the residual that may be left. preconditioner: null: none.
  [[nodiscard]] bool iterate(const Map& matrix, const Preconditioner* preconditioner, Eigen::Index most,
                             const Eigen::VectorXd& right_side, double allowed, double& mismatch, Eigen::VectorXd& x);
  // With the host's solver, or without.
  [[nodiscard]] bool iterate(const Map& matrix, const Preconditioner& solver, const Eigen::VectorXd& right_side,
                             double allowed, double& mismatch, Eigen::VectorXd& x);
  // The host's solver of this step, or still that of an earlier one.
  void prepare_system(bool anew);
  // The same without its matrix, if that can be, with the outputs of single nodes.
  [[nodiscard]] bool prepare_matrix_free();
  // What that makes of right-hand sides of A, or of A^T.
  void precondition(const Eigen::VectorXd& in, double accuracy, Eigen::VectorXd& out);
  void precondition_transposed(const Eigen::VectorXd& in, double accuracy, Eigen::VectorXd& out);
  void directly(const Eigen::VectorXd& right_side, bool transposed, Eigen::VectorXd& x);
  void clear_pinned(Eigen::VectorXd& values) const;
  void apply(const Eigen::VectorXd& in, Eigen::VectorXd& out);
  void apply_transposed(const Eigen::VectorXd& in, Eigen::VectorXd& out);
  [[nodiscard]] Eigen::Index most_iterations() const;

  LinearModel& linear_;
  sdk::Host host_;
  springnet_evaluation at_{};
  double w_ = 0.0;
  std::vector<double> mass_;          // [3 node]
  std::vector<Eigen::Index> pinned_;  // numbers of those whose motion is given
  bool factorised_ = false;
  // The host's system: of this step, or of so many steps ago; and whether it converges as it did at first.
  bool has_system_ = false, may_keep_ = false;
  int age_ = 0;
  double system_weight_ = 0.0;
  bool transposed_ = false;  // what is asked for
  // Of nodes whose outputs the system has; whether transposed.
  std::vector<layers::NodeResponse> responses_;
  bool system_transposed_ = false;
  std::vector<std::pair<std::uint32_t, Eigen::Matrix3d>> outside_;  // of their ranges
  Eigen::Index iterations_ = 0, first_iterations_ = 0;  // of the last solution, of that with a system of its own
  int prepared_steps_ = 0;                              // for which no other way is tried
  // What an exact solution by the preconditioner leaves of the residual, of A and of its transpose, as far as known.
  double mismatch_ = 0.0, transposed_mismatch_ = 0.0;
  std::vector<Eigen::VectorXd> basis_, images_;
  Eigen::VectorXd next_, work_, other_, by_position_, by_velocity_;
  const ConstrainedOutputs* outputs_ = nullptr;
};

}  // namespace springnet::learning
