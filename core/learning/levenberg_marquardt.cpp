#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/QR>

#include "learning/course.hpp"
#include "learning/minimise.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// With less damping rounding alone would move values along directions that the residuals do not depend on.
constexpr double first_damping = 1e-3, least_damping = 1e-12, most_damping = 1e20;
constexpr double least_model_gain = 1e-4;  // of the decrease that the linear model predicts
constexpr int most_inner = 500;            // conjugate gradients
constexpr double loosest_inner = 0.1, tightest_inner = 1e-8;

struct MarquardtState : SearchState {
  double damping = first_damping, growth = 2.0;
  VectorXd scale;  // see LinearisedProblem
  void archive(Archive& archive) {
    SearchState::archive(archive);
    archive.number(damping);
    archive.number(growth);
    archive_numbers(archive, scale, "scales of a search");
  }
};

// A step of the linear model at the present point: least |J s + r|^2 + damping |D s|^2 over the variables that may
// move.
class LinearisedProblem {
 public:
  // scale: as Moré has it, the greatest sensitivity to each variable so far, so that the search does not depend on
  // units; where Jacobians are not known, the one that the units let expect.
  LinearisedProblem(LeastSquares& problem, bool dense, VectorXd& scale, const Scaled& scaled)
      : problem_(problem), dense_(dense), scale_(scale), scaled_(scaled) {}

  void set(const VectorXd& x, const VectorXd& residuals, const Bounds& bounds) {
    problem_.linearise(x);
    residuals_ = residuals;
    if (dense_) jacobian_ = problem_.jacobian(x.size());
    gradient_ = dense_ ? VectorXd(jacobian_.transpose() * residuals) : problem_.transposed_times(residuals);
    if (dense_)
      for (Index k = 0; k < x.size(); ++k) scale_[k] = std::max(scale_[k], jacobian_.col(k).norm());
    else if (scale_.isZero(0.0))
      scale_ = scaled_.sensitivity(problem_, gradient_) * scaled_.unit().cwiseInverse();
    free_.clear();
    for (Index k = 0; k < x.size(); ++k)
      if (!is_held(x, gradient_, bounds, k)) free_.push_back(k);
    if (!dense_) return;
    MatrixXd own(jacobian_.rows(), static_cast<Index>(free_.size()));
    for (std::size_t j = 0; j < free_.size(); ++j) own.col(static_cast<Index>(j)) = jacobian_.col(free_[j]);
    // J = Q R once; each damping then has the small system of R.
    const Eigen::HouseholderQR<MatrixXd> qr(own);
    const Index rank = std::min(own.rows(), own.cols());
    triangle_ = qr.matrixQR().topRows(rank).triangularView<Eigen::Upper>();
    projected_ = (qr.householderQ().transpose() * residuals).head(rank);
  }

  [[nodiscard]] double gradient() const {
    const double size = residuals_.norm();
    double greatest = 0.0;
    for (const Index k : free_)
      if (scale_[k] > 0.0) greatest = std::max(greatest, std::abs(gradient_[k]) / scale_[k]);
    return size > 0.0 ? greatest / size : 0.0;
  }
  [[nodiscard]] double size_of(const VectorXd& x) const { return x.cwiseProduct(scale_).norm(); }

  [[nodiscard]] VectorXd step(double damping) {
    VectorXd result = VectorXd::Zero(scale_.size());
    if (free_.empty()) return result;
    const VectorXd own = dense_ ? dense_step(damping) : iterated_step(damping);
    for (std::size_t j = 0; j < free_.size(); ++j) result[free_[j]] = own[static_cast<Index>(j)];
    return result;
  }
  // Of the cost, by a step.
  [[nodiscard]] double predicted_decrease(const VectorXd& step) {
    const VectorXd change = dense_ ? VectorXd(jacobian_ * step) : problem_.times(step);
    return -(gradient_.dot(step) + 0.5 * change.squaredNorm());
  }

 private:
  [[nodiscard]] double weight(std::size_t j) const {
    const double own = scale_[free_[j]];
    return own > 0.0 ? own : 1.0;  // without influence: it stays
  }
  [[nodiscard]] VectorXd dense_step(double damping) const {
    const auto count = static_cast<Index>(free_.size());
    const Index rank = triangle_.rows();
    MatrixXd whole = MatrixXd::Zero(rank + count, count);
    whole.topRows(rank) = triangle_;
    for (std::size_t j = 0; j < free_.size(); ++j)
      whole(rank + static_cast<Index>(j), static_cast<Index>(j)) = std::sqrt(damping) * weight(j);
    VectorXd right = VectorXd::Zero(rank + count);
    right.head(rank) = -projected_;
    return whole.householderQr().solve(right);
  }
  // Conjugate gradients of the normal equations, by the variables in their units.
  [[nodiscard]] VectorXd iterated_step(double damping) {
    const auto count = static_cast<Index>(free_.size());
    const auto free = [&](Index j) { return free_[static_cast<std::size_t>(j)]; };
    const auto spread = [&](const VectorXd& of) {
      VectorXd all = VectorXd::Zero(scale_.size());
      for (Index j = 0; j < count; ++j) all[free(j)] = of[j] / scale_[free(j)];
      return all;
    };
    const auto gather = [&](const VectorXd& of) {
      VectorXd own(count);
      for (Index j = 0; j < count; ++j) own[j] = of[free(j)] / scale_[free(j)];
      return own;
    };
    VectorXd step = VectorXd::Zero(count), left = -gather(gradient_), direction = left;
    const double start = left.norm(), tolerance = std::clamp(gradient(), tightest_inner, loosest_inner) * start;
    double square = left.squaredNorm();
    for (int i = 0; i < most_inner && left.norm() > tolerance; ++i) {
      const VectorXd image = gather(problem_.transposed_times(problem_.times(spread(direction)))) + damping * direction;
      const double curvature = direction.dot(image);
      if (!(curvature > 0.0)) break;
      step += square / curvature * direction;
      left -= square / curvature * image;
      const double next = left.squaredNorm();
      direction = left + next / square * direction;
      square = next;
    }
    for (Index j = 0; j < count; ++j) step[j] /= scale_[free(j)];
    return step;
  }

  LeastSquares& problem_;
  bool dense_;
  VectorXd& scale_;
  const Scaled& scaled_;
  VectorXd residuals_, gradient_, projected_;
  MatrixXd jacobian_, triangle_;
  std::vector<Index> free_;
};

}  // namespace

Minimum levenberg_marquardt(LeastSquares& problem, const VectorXd& start, const Bounds& bounds,
                            const MinimiseOptions& options) {
  check_start(start, bounds, options);
  MarquardtState state;
  state.x = start;
  state.scale = VectorXd::Zero(start.size());
  take_up(state, options);
  VectorXd residuals = problem.residuals(state.x);
  double cost = cost_at_start(residuals);
  const bool dense = start.size() <= options.most_dense &&
                     static_cast<double>(start.size()) * static_cast<double>(residuals.size()) <= options.most_numbers;
  const Scaled scaled(bounds, options);
  LinearisedProblem model(problem, dense, state.scale, scaled);
  model.set(state.x, residuals, bounds);
  const Course course(options);
  while (true) {
    keep(state, options);
    if (const auto ended = course.ends(state, cost, model.gradient())) return *ended;
    while (true) {
      VectorXd x = (state.x + model.step(state.damping)).cwiseMax(bounds.lower).cwiseMin(bounds.upper);
      const VectorXd step = x - state.x;
      const double predicted = model.predicted_decrease(step);
      if (model.size_of(step) <= options.step_tolerance * model.size_of(state.x))
        return course.end_by_step(state, cost);
      const auto shorten = [&] {
        state.damping *= state.growth;
        state.growth *= 2.0;
        return state.damping < most_damping;
      };
      // Cut by bounds, a step may lead upwards; a shorter one does not.
      if (predicted < 0.0) {
        if (shorten()) continue;
        return course.end_stuck(state, cost);
      }
      VectorXd next = problem.residuals(x);
      const double next_cost = 0.5 * next.squaredNorm(), gain = (cost - next_cost) / predicted;
      if (std::isfinite(next_cost) && predicted > 0.0 && gain > least_model_gain) {
        course.go_on(state, std::move(x), cost, next_cost);
        residuals = std::move(next);
        cost = next_cost;
        state.damping =
            std::max(least_damping, state.damping * std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3.0)));
        state.growth = 2.0;
        model.set(state.x, residuals, bounds);
        break;
      }
      if (predicted <= rounding_of_cost * cost) return course.end_by_rounding(state, cost);
      if (!shorten()) return course.end_stuck(state, cost);
    }
  }
}

}  // namespace springnet::learning
