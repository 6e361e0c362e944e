#include "linear_solver.hpp"

#include <algorithm>
#include <cstddef>
#include <new>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>

namespace springnet::cvode {
namespace {

using Map = Eigen::Map<Eigen::VectorXd>;
using ConstMap = Eigen::Map<const Eigen::VectorXd>;

class Direct final : public NewtonSystem {
 public:
  Direct(void* memory, Equations& equations, const Context& context)
      : equations_(equations),
        right_side_(3 * static_cast<Eigen::Index>(equations.node_count())),
        push_(right_side_.size()),
        matrix_(SUNMatNewEmpty(context.get())),
        solver_(SUNLinSolNewEmpty(context.get())) {
    if (!matrix_ || !solver_) throw std::bad_alloc();
    // The host holds the matrix; CVODE passes this object to the functions below.
    matrix_->content = this;
    matrix_->ops->getid = [](SUNMatrix) { return SUNMATRIX_CUSTOM; };
    solver_->content = this;
    solver_->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; };
    solver_->ops->getid = [](SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; };
    solver_->ops->setup = [](SUNLinearSolver solver, SUNMatrix) {
      auto& self = *static_cast<Direct*>(solver->content);
      return self.equations_.factorise(self.gamma_);
    };
    solver_->ops->solve = [](SUNLinearSolver solver, SUNMatrix, N_Vector x, N_Vector b, sunrealtype) {
      return static_cast<Direct*>(solver->content)->solve(data(b), data(x));
    };
    if (CVodeSetLinearSolver(memory, solver_.get(), matrix_.get()) != 0 ||
        CVodeSetLinSysFn(memory, &Direct::linear_system) != 0) {
      throw std::bad_alloc();
    }
  }

 private:
  // jok: derivatives of an earlier state are good enough; only gamma has changed.
  static int linear_system(double time, N_Vector y, N_Vector, SUNMatrix matrix, sunbooleantype jok,
                           sunbooleantype* jcur, double gamma, void*, N_Vector, N_Vector, N_Vector) {
    auto& self = *static_cast<Direct*>(matrix->content);
    self.gamma_ = gamma;
    const bool anew = jok == SUNFALSE || self.equations_.internal_count() > 0;
    *jcur = anew ? SUNTRUE : SUNFALSE;
    return anew ? self.equations_.linearise(time, y, gamma) : 0;
  }

  int solve(const double* b, double* x) noexcept {
    const Eigen::Index size = right_side_.size();
    const ConstMap rp(b, size);
    const ConstMap rv(b + size, size);
    Map dp(x, size);
    Map dv(x + size, size);
    dv.setZero();
    if (const int status = equations_.jacobian_times(b, dv.data(), right_side_.data()); status != 0) return status;
    right_side_ = rv + gamma_ * right_side_;
    const bool internal = equations_.internal_count() > 0;
    const double* const rz = b + 2 * size;
    if (internal) {
      if (const int status = equations_.change_internal(rz, nullptr, nullptr, nullptr, push_.data()); status != 0)
        return status;
      right_side_ += gamma_ * push_;
    }
    if (const int status = equations_.solve(right_side_.data(), dv.data()); status != 0) return status;
    dp = rp + gamma_ * dv;
    return internal ? equations_.change_internal(rz, dp.data(), dv.data(), x + 2 * size, nullptr) : 0;
  }

  Equations& equations_;
  double gamma_ = 0.0;                 // s
  Eigen::VectorXd right_side_, push_;  // push_: accelerations by internal states
  Matrix matrix_;
  CustomLinearSolver solver_;
};

class Krylov final : public NewtonSystem {
 public:
  // Enough for block Jacobi on a lattice at the steps that the default tolerance allows; 6 node_count numbers each.
  static constexpr int max_vectors = 40;

  Krylov(void* memory, N_Vector y, Equations& equations, const Context& context)
      : equations_(equations),
        coupling_(9 * equations.node_count()),
        inverse_(9 * equations.node_count()),
        push_(3 * equations.node_count()),
        solver_(SUNLinSol_SPGMR(y, SUN_PREC_RIGHT, max_vectors, context.get())) {
    // With internal states products are differences of right-hand sides.
    const bool analytic = equations.internal_count() == 0;
    if (!solver_ || CVodeSetLinearSolver(memory, solver_.get(), nullptr) != 0 ||
        (analytic && CVodeSetJacTimes(memory, nullptr, &Krylov::jacobian_times) != 0) ||
        CVodeSetPreconditioner(memory, &Krylov::set_up, &Krylov::precondition) != 0) {
      throw std::bad_alloc();
    }
  }

 private:
  using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

  static Krylov& of(void* callbacks) noexcept {
    return static_cast<Krylov&>(*static_cast<Callbacks*>(callbacks)->newton);
  }

  // J (vp, vv) = (vv, a_p vp + a_v vv)
  static int jacobian_times(N_Vector v, N_Vector product, double, N_Vector, N_Vector, void* callbacks, N_Vector) {
    Krylov& self = of(callbacks);
    const std::size_t size = 3 * self.equations_.node_count();
    std::copy_n(data(v) + size, size, data(product));
    return self.equations_.jacobian_times(data(v), data(v) + size, data(product) + size);
  }

  static int set_up(double time, N_Vector y, N_Vector, sunbooleantype jok, sunbooleantype* jcur, double gamma,
                    void* callbacks) {
    Krylov& self = of(callbacks);
    const bool anew = jok == SUNFALSE || self.equations_.internal_count() > 0;
    *jcur = anew ? SUNTRUE : SUNFALSE;
    if (anew) {
      if (const int status = self.equations_.linearise(time, y, gamma); status != 0) return status;
    }
    if (const int status = self.invert_blocks(gamma); status != 0) return status;
    self.bound_ = self.equations_.bound();
    if (self.bound_) self.set_mobilities();
    return 0;
  }

  // Mobilities of the nodes in the preconditioner, for the projection onto the constraints.
  void set_mobilities() {
    const springnet_network& network = equations_.host().network();
    mobility_.resize(inverse_.size());
    for (std::size_t k = 0; k < network.node_count; ++k) {
      const Block inverse = Eigen::Map<const Block>(&inverse_[9 * k]) / network.mass[k];
      Eigen::Map<Block> mobility(&mobility_[9 * k]);
      mobility = 0.5 * (inverse + inverse.transpose());
    }
  }

  // coupling = gamma a_p, inverse = (I - gamma a_v - gamma^2 a_p)^-1, of each node alone.
  int invert_blocks(double gamma) noexcept {
    gamma_ = gamma;
    if (const int status = equations_.diagonal_blocks(0.0, gamma, coupling_.data()); status != 0) return status;
    if (const int status = equations_.diagonal_blocks(gamma, gamma * gamma, inverse_.data()); status != 0)
      return status;
    for (std::size_t i = 0; i < coupling_.size(); i += 9) {
      Eigen::Map<Block> coupling(&coupling_[i]);
      coupling = Block::Identity() - coupling;
      Eigen::Map<Block> inverse(&inverse_[i]);
      inverse = Block(inverse).inverse();
      if (!inverse.allFinite()) return 1;  // singular: recoverable, since a smaller step has another gamma
    }
    return 0;
  }

  static int precondition(double, N_Vector, N_Vector, N_Vector r, N_Vector z, double, double, int, void* callbacks) {
    Krylov& self = of(callbacks);
    const std::size_t n = self.equations_.node_count();
    const double* rp = data(r);
    const double* rv = rp + 3 * n;
    const double* const rz = rp + 6 * n;
    const bool internal = self.equations_.internal_count() > 0;
    if (internal) {
      std::vector<double>& push = self.push_;
      if (const int status = self.equations_.change_internal(rz, nullptr, nullptr, nullptr, push.data()); status != 0)
        return status;
      for (std::size_t i = 0; i < 3 * n; ++i) push[i] = rv[i] + self.gamma_ * push[i];
      rv = push.data();
    }
    double* dp = data(z);
    double* dv = dp + 3 * n;
    for (std::size_t k = 0; k < n; ++k) {
      const Eigen::Vector3d position(rp[k], rp[k + n], rp[k + 2 * n]);
      const Eigen::Vector3d velocity(rv[k], rv[k + n], rv[k + 2 * n]);
      const Eigen::Map<const Block> coupling(&self.coupling_[9 * k]);
      const Eigen::Map<const Block> inverse(&self.inverse_[9 * k]);
      const Eigen::Vector3d x = inverse * (velocity + coupling * position);
      for (int c = 0; c < 3; ++c) dv[k + static_cast<std::size_t>(c) * n] = x[c];
    }
    if (self.bound_) {
      // Project only the difference: the result violates the constraints as much as the right side.
      for (std::size_t i = 0; i < 3 * n; ++i) dv[i] -= rv[i];
      if (const int status = self.equations_.project(self.mobility_.data(), dv); status != 0) return status;
      for (std::size_t i = 0; i < 3 * n; ++i) dv[i] += rv[i];
    }
    for (std::size_t i = 0; i < 3 * n; ++i) dp[i] = rp[i] + self.gamma_ * dv[i];
    return internal ? self.equations_.change_internal(rz, dp, dv, data(z) + 6 * n, nullptr) : 0;
  }

  Equations& equations_;
  double gamma_ = 0.0;            // s, of the blocks
  std::vector<double> coupling_;  // [node][3][3]
  std::vector<double> inverse_;   // [node][3][3]
  bool bound_ = false;
  std::vector<double> mobility_;  // [node][3][3] 1/kg, if the motion is constrained
  std::vector<double> push_;      // [3 node], with internal states
  LinearSolver solver_;
};

}  // namespace

void attach_direct(void* memory, Callbacks& callbacks, const Context& context) {
  callbacks.newton = std::make_unique<Direct>(memory, callbacks.equations, context);
}

void attach_krylov(void* memory, N_Vector y, Callbacks& callbacks, const Context& context) {
  callbacks.newton = std::make_unique<Krylov>(memory, y, callbacks.equations, context);
}

}  // namespace springnet::cvode
