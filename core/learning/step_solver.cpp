#include "learning/step_solver.hpp"

#include <algorithm>
#include <cmath>

#include "learning/node_vectors.hpp"

namespace springnet::learning {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index most_unconstrained = 40;
// The preconditioner may not know of constraints, each of which may then take an iteration.
constexpr Eigen::Index most_constrained = 1000;
// Without a preconditioner: more than these take longer than to prepare one. It is tried again after some steps.
constexpr Eigen::Index most_plain = 12;
constexpr int steps_until_tried = 20;
// The host's solver need not be more accurate than what it leaves even if it is exact; and it may be better in steps to
// come.
constexpr double loosest_linear = 0.03, tightest_linear = 1e-4, forgetting = 0.5;
// Steps that a system is kept for, while it takes at most so many iterations more than at first.
constexpr int most_steps_kept = 10;
constexpr Eigen::Index more_iterations = 1;
// A factorisation takes as long as so many solutions by iteration, in nets of up to so many nodes.
constexpr Eigen::Index solutions_worth_factors = 20;
constexpr std::size_t most_nodes_factorised = 1000;

}  // namespace

void StepSolver::prepare(const springnet_evaluation& at, double w, Eigen::Index solutions,
                         const ConstrainedOutputs* outputs) {
  const springnet_network& network = host_.network();
  const std::size_t n = network.node_count;
  mass_.resize(3 * n);
  for (std::size_t axis = 0; axis < 3; ++axis)
    std::copy_n(network.mass, n, mass_.begin() + static_cast<std::ptrdiff_t>(axis * n));
  find_pinned(network, pinned_);
  at_ = at;
  w_ = w;
  outputs_ = outputs != nullptr && outputs->any() ? outputs : nullptr;
  factorised_ = has_system_ = false;
  ++age_;
  if (prepared_steps_ > 0) --prepared_steps_;
  host_.linearise(at);
  if (solutions >= solutions_worth_factors && n <= most_nodes_factorised && outputs_ == nullptr) {
    host_.factorise(w, w * w);
    factorised_ = true;
  }
  for (VectorXd* each : {&work_, &other_, &by_position_, &by_velocity_}) each->resize(static_cast<Eigen::Index>(3 * n));
}

void StepSolver::begin() noexcept {
  linear_.forget_solutions();
  may_keep_ = false;
  prepared_steps_ = 0;
  mismatch_ = transposed_mismatch_ = 0.0;
}

void StepSolver::prepare_system(bool anew) {
  if (has_system_ && !anew && (responses_.empty() || system_transposed_ == transposed_)) return;
  has_system_ = true;
  if (!anew && may_keep_ && age_ <= most_steps_kept && linear_.is_prepared() &&
      std::abs(w_ - system_weight_) <= 1e-9 * w_)
    return;
  const bool is_matrix_free = prepare_matrix_free();
  if (!is_matrix_free) host_.prepare_system({w_, w_ * w_});
  // Without a matrix it takes little time; and where iterations give up, the host linearises at the state it is of.
  may_keep_ = !is_matrix_free;
  age_ = 0;
  first_iterations_ = 0;
  system_weight_ = w_;
}

bool StepSolver::prepare_matrix_free() {
  responses_.clear();
  if (outputs_ != nullptr) responses_ = outputs_->responses(transposed_);
  system_transposed_ = transposed_;
  layers::NodeResponses parts;
  parts.set(responses_);
  outside_.clear();
  parts.for_each_range([this](std::uint32_t node, const Eigen::Matrix3d& range) {
    outside_.emplace_back(node, Eigen::Matrix3d::Identity() - range);
  });
  if (linear_.prepare_matrix_free(at_, {w_, w_ * w_, 0.0}, &responses_)) return true;
  responses_.clear();
  outside_.clear();
  return false;
}

void StepSolver::precondition(const VectorXd& in, double accuracy, VectorXd& out) {
  if (responses_.empty()) {
    static_cast<void>(host_.solve_system(in.data(), accuracy, out.data()));
    return;
  }
  // Of nodes with rigid connections the system knows nothing: they go through it as if they were free.
  const auto n = static_cast<Eigen::Index>(mass_.size() / 3);
  work_ = in;
  for (const layers::NodeResponse& each : responses_) {
    const Eigen::Index k = each.node;
    const Eigen::Vector3d answer = each.response * Eigen::Vector3d(in[k], in[n + k], in[2 * n + k]);
    for (Eigen::Index axis = 0; axis < 3; ++axis) work_[axis * n + k] = answer[axis];
  }
  static_cast<void>(host_.solve_system(work_.data(), accuracy, out.data()));
  work_ = w_ * out;
  host_.jacobian_times(work_.data(), out.data(), by_position_.data());
  for (const layers::NodeResponse& each : responses_) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const Eigen::Index i = axis * n + each.node;
      out[i] = in[i] + w_ * by_position_[i];
    }
  }
}

void StepSolver::precondition_transposed(const VectorXd& in, double accuracy, VectorXd& out) {
  const Eigen::Map<const VectorXd> mass(mass_.data(), static_cast<Eigen::Index>(mass_.size()));
  work_ = in.cwiseQuotient(mass);
  static_cast<void>(host_.solve_system(work_.data(), accuracy, out.data()));
  out = out.cwiseProduct(mass);
  const auto n = static_cast<Eigen::Index>(mass_.size() / 3);
  for (const auto& [node, outside] : outside_) {
    const Eigen::Index k = node;
    const Eigen::Vector3d left = outside * Eigen::Vector3d(in[k], in[n + k], in[2 * n + k]);
    for (Eigen::Index axis = 0; axis < 3; ++axis) out[axis * n + k] += left[axis];
  }
}

void StepSolver::clear_pinned(VectorXd& values) const {
  for (const Eigen::Index i : pinned_) values[i] = 0.0;
}

Eigen::Index StepSolver::most_iterations() const {
  return outputs_ == nullptr ? most_unconstrained
                             : std::min(most_constrained, static_cast<Eigen::Index>(mass_.size()) + 1);
}

void StepSolver::apply(const VectorXd& in, VectorXd& out) {
  if (outputs_ == nullptr) {
    work_ = w_ * in;
    host_.jacobian_times(work_.data(), in.data(), by_position_.data());
  } else {
    outputs_->from_free(in, work_, other_);
    host_.jacobian_times(work_.data(), other_.data(), by_position_.data());
  }
  out = in - w_ * by_position_;
  clear_pinned(out);
}

void StepSolver::apply_transposed(const VectorXd& in, VectorXd& out) {
  if (outputs_ == nullptr) {
    out.resize(in.size());
    linear_.weighted_transposed_times(w_, w_ * w_, in.data(), out.data());
    out = in - out;
    clear_pinned(out);
    return;
  }
  host_.jacobian_transposed_times(in.data(), by_position_.data(), by_velocity_.data());
  outputs_->to_free(by_position_, by_velocity_, work_);
  out = in - w_ * work_;
  clear_pinned(out);
}

void StepSolver::solve(const VectorXd& right_side, double accuracy, VectorXd& x) {
  const auto matrix = [this](const VectorXd& in, VectorXd& out) { apply(in, out); };
  const auto preconditioner = [this](const VectorXd& in, double inner, VectorXd& out) { precondition(in, inner, out); };
  transposed_ = false;
  if (factorised_ || !iterate(matrix, preconditioner, right_side, accuracy * right_side.norm(), mismatch_, x))
    directly(right_side, false, x);
}

void StepSolver::solve_transposed(const VectorXd& right_side, double accuracy, VectorXd& x, VectorXd& by_position,
                                  VectorXd& by_velocity) {
  const auto matrix = [this](const VectorXd& in, VectorXd& out) { apply_transposed(in, out); };
  const auto preconditioner = [this](const VectorXd& in, double inner, VectorXd& out) {
    precondition_transposed(in, inner, out);
  };
  transposed_ = true;
  const double size = right_side.norm(), allowed = accuracy * size;
  VectorXd left;
  bool is_near = false;
  if (x.size() == right_side.size() && !x.isZero(0.0)) {
    clear_pinned(x);
    apply_transposed(x, left);
    left = right_side - left;
    is_near = left.norm() < size;
  }
  if (!is_near) {
    x.setZero(right_side.size());
    left = right_side;
  }
  if (left.norm() > allowed) {
    VectorXd change;
    if (!factorised_ && iterate(matrix, preconditioner, left, allowed, transposed_mismatch_, change))
      x += change;
    else
      directly(right_side, true, x);
  }
  if (outputs_ != nullptr) {
    host_.jacobian_transposed_times(x.data(), by_position.data(), by_velocity.data());
    return;
  }
  // The system itself tells the other one, to its accuracy.
  linear_.weighted_transposed_times(0.0, 1.0, x.data(), by_position.data());
  by_velocity = (x - right_side) / w_ - w_ * by_position;
}

bool StepSolver::iterate(const Map& matrix, const Preconditioner& solver, const VectorXd& right_side, double allowed,
                         double& mismatch, VectorXd& x) {
  if (!has_system_ && prepared_steps_ == 0) {
    double none = 0.0;
    if (iterate(matrix, nullptr, most_plain, right_side, allowed, none, x)) return true;
    prepared_steps_ = steps_until_tried;
  }
  prepare_system(false);
  bool settled = iterate(matrix, &solver, most_iterations(), right_side, allowed, mismatch, x);
  if (!settled && age_ > 0) {
    prepare_system(true);
    settled = iterate(matrix, &solver, most_iterations(), right_side, allowed, mismatch, x);
  }
  if (age_ == 0 && first_iterations_ == 0) first_iterations_ = iterations_;
  may_keep_ = may_keep_ && settled && iterations_ <= first_iterations_ + more_iterations;
  return settled;
}

// Arnoldi's basis by modified Gram-Schmidt, least squares by Givens rotations. False: no convergence.
bool StepSolver::iterate(const Map& matrix, const Preconditioner* preconditioner, Eigen::Index most,
                         const VectorXd& right_side, double allowed, double& mismatch, VectorXd& x) {
  const double size = right_side.norm();
  x.setZero(right_side.size());
  if (!(size > 0.0)) return size == 0.0;
  if (basis_.empty()) basis_.emplace_back();
  basis_[0] = right_side / size;
  std::vector<VectorXd> columns;  // of the triangle
  VectorXd g = VectorXd::Zero(most + 1), cosine(most), sine(most);
  g[0] = size;
  Eigen::Index count = 0;
  bool settled = false;
  VectorXd& next = next_;
  while (count < most && !settled) {
    const Eigen::Index k = count++;
    const auto number = static_cast<std::size_t>(k);
    const double left = std::abs(g[k]);
    const double inner = std::clamp(std::max(mismatch, 0.3 * allowed / left), tightest_linear, loosest_linear);
    if (preconditioner == nullptr) {
      matrix(basis_[number], next);
    } else {
      if (images_.size() <= number) images_.emplace_back();
      images_[number].resize(right_side.size());
      (*preconditioner)(basis_[number], inner, images_[number]);
      if (!images_[number].allFinite()) return false;
      matrix(images_[number], next);
    }
    VectorXd& h = columns.emplace_back(k + 2);
    for (Eigen::Index i = 0; i <= k; ++i) {
      h[i] = basis_[static_cast<std::size_t>(i)].dot(next);
      next -= h[i] * basis_[static_cast<std::size_t>(i)];
    }
    const double length = h[k + 1] = next.norm();
    for (Eigen::Index i = 0; i < k; ++i) {
      const double upper = cosine[i] * h[i] + sine[i] * h[i + 1];
      h[i + 1] = -sine[i] * h[i] + cosine[i] * h[i + 1];
      h[i] = upper;
    }
    const double radius = std::hypot(h[k], h[k + 1]);
    if (!(radius > 0.0) || !std::isfinite(radius)) return false;
    cosine[k] = h[k] / radius;
    sine[k] = h[k + 1] / radius;
    h[k] = radius;
    g[k + 1] = -sine[k] * g[k];
    g[k] *= cosine[k];
    settled = std::abs(g[k + 1]) <= allowed;
    const double reduction = std::abs(g[k + 1]) / left;
    if (reduction > 3.0 * inner) mismatch = std::max(mismatch, reduction);
    if (!settled && !(length > 0.0)) return false;
    if (settled) break;
    if (basis_.size() <= number + 1) basis_.emplace_back();
    basis_[number + 1] = next / length;
  }
  iterations_ = count;
  if (!settled) return false;
  mismatch *= forgetting;
  for (Eigen::Index k = count; k-- > 0;) {  // backwards through the triangle
    const VectorXd& h = columns[static_cast<std::size_t>(k)];
    g[k] /= h[k];
    g.head(k) -= g[k] * h.head(k);
    x += g[k] * (preconditioner != nullptr ? images_ : basis_)[static_cast<std::size_t>(k)];
  }
  clear_pinned(x);
  return true;
}

void StepSolver::directly(const VectorXd& right_side, bool transposed, VectorXd& x) {
  if (outputs_ != nullptr)
    throw sdk::Failure("the derivatives of a step with constraints do not settle; use a smaller time step");
  if (!factorised_) host_.factorise(w_, w_ * w_);
  factorised_ = true;
  x.resize(right_side.size());
  if (transposed)
    host_.solve_transposed(right_side.data(), x.data());
  else
    host_.solve(right_side.data(), x.data());
  clear_pinned(x);
}

}  // namespace springnet::learning
