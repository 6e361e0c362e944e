#include "linear_system.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <Eigen/IterativeLinearSolvers>

#include "matrix_free.hpp"

namespace springnet::recurrent {
namespace {

using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// Nodes up to which the system is always factorised, and up to which factorisation is the fallback (measured on
// lattices: from 64 nodes on it takes longer than iterations, unless these are many).
constexpr std::uint32_t max_nodes_direct = 32, max_nodes_fallback = 3000;
constexpr Eigen::Index max_iterations = 400, fallback_iterations = 100;
// Relative residual above which the result of an iteration is rejected if there is no fallback.
constexpr double max_useful_residual = 0.5;
// Checked after every `fallback_iterations`: multiple of the accuracy that is good enough, and the factor by which the
// error must fall to continue.
constexpr double nearly_accurate = 2.0, stall_factor = 0.5;

}  // namespace

void LinearSystem::attach(const springnet_network& network) {
  nodes_ = network.node_count;
  direct_ = network.node_count <= max_nodes_direct;
  may_factorise_ = network.node_count <= max_nodes_fallback;
  constrained_ = network.surface_count > 0 || network.rigid_count > 0;
  factorised_ = false;
  mass_.assign(network.mass, network.mass + nodes_);
  scaled_p_.resize(3 * nodes_);
  scaled_v_.resize(3 * nodes_);
  work_.resize(3 * nodes_);
  if (direct_) return;
  inverse_.resize(9 * nodes_);
  if (constrained_) mobility_.resize(9 * nodes_);
}

void LinearSystem::linearise(const springnet_evaluation& at) {
  host_.linearise(at);
  factorised_ = false;
}

void LinearSystem::project(std::vector<double>& values) const {
  if (constrained_) host_.project(nullptr, values.data());
}

// (1 + shift) (I - w_v da/dv - w_p da/dp) with weights that are smaller by 1 + shift: of the form that the host knows.
bool LinearSystem::solve(double weight, double shift, const std::vector<double>& b, double accuracy,
                         std::vector<double>& x) {
  const double scale = 1.0 / (1.0 + shift);
  const double velocity_weight = scale * weight, position_weight = scale * weight * weight;
  for (std::size_t i = 0; i < b.size(); ++i) work_[i] = scale * b[i];
  try {
    bool is_solved = !direct_ && iterate(velocity_weight, position_weight, work_, accuracy, x);
    if (!direct_ && !is_solved && may_factorise_) {
      // As with a long chain: many iterations, but a sparse factorisation.
      direct_ = true;
      factorised_ = false;
    }
    if (direct_) is_solved = solve_directly(velocity_weight, position_weight, work_, x);
    return is_solved && std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
  } catch (const sdk::Failure& failure) {
    if (!failure.recoverable()) throw;
    return false;
  }
}

bool LinearSystem::solve_directly(double velocity_weight, double position_weight, const std::vector<double>& b,
                                  std::vector<double>& x) {
  if (!factorised_ || velocity_weight_ != velocity_weight || position_weight_ != position_weight) {
    factorised_ = false;
    host_.factorise(velocity_weight, position_weight);
    velocity_weight_ = velocity_weight;
    position_weight_ = position_weight;
    factorised_ = true;
  }
  host_.solve(b.data(), x.data());
  return true;
}

// Inverts the diagonal blocks; with constraints also sets the nodes' mobilities, which must be symmetric and positive
// definite.
void LinearSystem::make_preconditioner(double velocity_weight, double position_weight) {
  if (factorised_ && velocity_weight_ == velocity_weight && position_weight_ == position_weight) return;
  host_.diagonal_blocks(velocity_weight, position_weight, inverse_.data());
  for (std::size_t k = 0; k < nodes_; ++k) {
    Eigen::Map<Block> block(inverse_.data() + 9 * k);
    const Eigen::Matrix3d symmetric = 0.5 * (block + block.transpose());
    const Eigen::LLT<Eigen::Matrix3d> factors(symmetric);
    const bool definite = factors.info() == Eigen::Success;
    if (constrained_) {
      Eigen::Map<Block> mobility(mobility_.data() + 9 * k);
      mobility = Block::Identity() / mass_[k];
      if (definite) mobility = factors.solve(Eigen::Matrix3d::Identity()) / mass_[k];
      mobility = Block(0.5 * (mobility + mobility.transpose()));
    }
    block = definite ? Block(Block(block).inverse()) : Block(Block::Identity());
  }
  velocity_weight_ = velocity_weight;
  position_weight_ = position_weight;
  factorised_ = true;
}

bool LinearSystem::iterate(double velocity_weight, double position_weight, const std::vector<double>& b,
                           double accuracy, std::vector<double>& x) {
  make_preconditioner(velocity_weight, position_weight);
  const auto size = static_cast<Eigen::Index>(3 * nodes_);
  const MatrixFree matrix(size, [&](const Eigen::VectorXd& in, Eigen::VectorXd& out) {
    for (Eigen::Index i = 0; i < size; ++i) {
      scaled_v_[static_cast<std::size_t>(i)] = velocity_weight * in[i];
      scaled_p_[static_cast<std::size_t>(i)] = position_weight * in[i];
    }
    host_.jacobian_times(scaled_p_.data(), scaled_v_.data(), out.data());
    out = in - out;
    if (constrained_) host_.project(nullptr, out.data());
  });
  Eigen::BiCGSTAB<MatrixFree, Action> solver;
  solver.preconditioner().apply = [&](const Eigen::VectorXd& in, Eigen::VectorXd& out) {
    const auto n = static_cast<Eigen::Index>(nodes_);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::Map<const Block> inverse(inverse_.data() + 9 * k);
      const Eigen::Vector3d value = inverse * Eigen::Vector3d(in[k], in[n + k], in[2 * n + k]);
      out[k] = value[0];
      out[n + k] = value[1];
      out[2 * n + k] = value[2];
    }
    if (constrained_) host_.project(mobility_.data(), out.data());
  };
  solver.compute(matrix);
  solver.setTolerance(accuracy);
  solver.setMaxIterations(fallback_iterations);
  Eigen::Map<Eigen::VectorXd> solution(x.data(), size);
  const Eigen::Map<const Eigen::VectorXd> right_side(b.data(), size);
  solution.setZero();
  // In parts: if pre-stress makes the matrix indefinite, the iteration may stall slightly above the accuracy.
  double last = 1.0;
  for (Eigen::Index done = 0; done < (may_factorise_ ? fallback_iterations : max_iterations);) {
    solution = solver.solveWithGuess(right_side, solution);
    done += fallback_iterations;
    host_.report("krylov_iterations", krylov_iterations_ += static_cast<double>(solver.iterations()));
    if (solver.error() <= nearly_accurate * accuracy || !(solver.error() <= stall_factor * last)) break;
    last = solver.error();
  }
  return solver.error() <= (may_factorise_ ? accuracy : max_useful_residual);
}

}  // namespace springnet::recurrent
