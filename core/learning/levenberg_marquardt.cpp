#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <Eigen/QR>

#include <springnet/error.hpp>

#include "learning/minimise.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Stop = Minimum::Stop;

constexpr double first_damping = 1e-3, most_damping = 1e20;
constexpr double least_gain = 1e-4;         // of the decrease that the linear model predicts
constexpr double rounding_of_cost = 1e-15;  // relative
constexpr int most_inner = 500;             // conjugate gradients
constexpr double loosest_inner = 0.1, tightest_inner = 1e-8;

void check(const VectorXd& start, const Bounds& bounds) {
  if (bounds.lower.size() != start.size() || bounds.upper.size() != start.size())
    throw Error(ErrorKind::input, fmt::format("a search of {} variables has {} lower and {} upper bounds", start.size(),
                                              bounds.lower.size(), bounds.upper.size()));
  for (Index k = 0; k < start.size(); ++k)
    if (!(bounds.lower[k] <= start[k] && start[k] <= bounds.upper[k]) || !std::isfinite(start[k]))
      throw Error(ErrorKind::input, fmt::format("variable {} starts at {}, which is not within {} and {}", k, start[k],
                                                bounds.lower[k], bounds.upper[k]));
}

// A step of the linear model at the present point: least |J s + r|^2 + damping |D s|^2 over the variables that may
// move.
class LinearModel {
 public:
  LinearModel(LeastSquares& problem, bool dense, Index variables)
      : problem_(problem), dense_(dense), scale_(VectorXd::Zero(variables)) {}

  void set(const VectorXd& x, const VectorXd& residuals, const Bounds& bounds) {
    problem_.linearise(x);
    residuals_ = residuals;
    if (dense_) jacobian_ = problem_.jacobian(x.size());
    gradient_ = dense_ ? VectorXd(jacobian_.transpose() * residuals) : problem_.transposed_times(residuals);
    // As Moré has it: the greatest sensitivity so far, so that the search does not depend on units.
    for (Index k = 0; k < x.size(); ++k) {
      const double own = dense_ ? jacobian_.col(k).norm() : 1.0;
      scale_[k] = std::max(scale_[k], own);
    }
    free_.clear();
    for (Index k = 0; k < x.size(); ++k) {
      const bool stays = bounds.lower[k] == bounds.upper[k] || (x[k] <= bounds.lower[k] && gradient_[k] > 0.0) ||
                         (x[k] >= bounds.upper[k] && gradient_[k] < 0.0);
      if (!stays) free_.push_back(k);
    }
    if (!dense_) return;
    MatrixXd own(jacobian_.rows() + 0, static_cast<Index>(free_.size()));
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
  // Conjugate gradients of the normal equations.
  [[nodiscard]] VectorXd iterated_step(double damping) {
    const auto count = static_cast<Index>(free_.size());
    const auto spread = [&](const VectorXd& of) {
      VectorXd all = VectorXd::Zero(scale_.size());
      for (Index j = 0; j < count; ++j) all[free_[static_cast<std::size_t>(j)]] = of[j];
      return all;
    };
    const auto gather = [&](const VectorXd& of) {
      VectorXd own(count);
      for (Index j = 0; j < count; ++j) own[j] = of[free_[static_cast<std::size_t>(j)]];
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
    return step;
  }

  LeastSquares& problem_;
  bool dense_;
  VectorXd scale_, residuals_, gradient_, projected_;
  MatrixXd jacobian_, triangle_;
  std::vector<Index> free_;
};

}  // namespace

Minimum levenberg_marquardt(LeastSquares& problem, const VectorXd& start, const Bounds& bounds,
                            const MinimiseOptions& options) {
  check(start, bounds);
  Minimum result;
  result.x = start;
  VectorXd residuals = problem.residuals(start);
  result.cost = 0.5 * residuals.squaredNorm();
  if (!std::isfinite(result.cost))
    throw Error(ErrorKind::input, "the search starts where residuals are not finite; start from other values");
  const auto end = [&](Stop stop, std::string reason) {
    result.stop = stop;
    result.reason = std::move(reason);
    return result;
  };
  const bool dense = start.size() <= options.most_dense &&
                     static_cast<double>(start.size()) * static_cast<double>(residuals.size()) <= options.most_numbers;
  LinearModel model(problem, dense, start.size());
  model.set(result.x, residuals, bounds);
  double damping = first_damping, growth = 2.0;
  for (int iteration = 0;; ++iteration) {
    const Progress now{iteration, result.cost, model.gradient()};
    result.history.push_back(now);
    if (options.on_iteration && !options.on_iteration(now, result.x))
      return end(Stop::asked, "It was stopped; the values are the best until then.");
    if (!(now.gradient > options.gradient_tolerance))
      return end(Stop::gradient, fmt::format("The gradient is {:.1e} of what it could be, at most {:.1e}.",
                                             now.gradient, options.gradient_tolerance));
    if (iteration == options.max_iterations)
      return end(Stop::iterations, fmt::format("All {} iterations were made; more may find better values.", iteration));
    while (true) {
      VectorXd x = (result.x + model.step(damping)).cwiseMax(bounds.lower).cwiseMin(bounds.upper);
      const VectorXd step = x - result.x;
      const double predicted = model.predicted_decrease(step);
      if (model.size_of(step) <= options.step_tolerance * model.size_of(result.x))
        return end(Stop::step, fmt::format("Steps are shorter than {:.1e} of the values.", options.step_tolerance));
      const auto shorten = [&] {
        damping *= growth;
        growth *= 2.0;
        return damping < most_damping;
      };
      constexpr const char* stuck = "No step lowers the cost, however short; the motion may fail at the values nearby.";
      // Cut by bounds, a step may lead upwards; a shorter one does not.
      if (predicted < 0.0) {
        if (shorten()) continue;
        return end(Stop::stuck, stuck);
      }
      VectorXd next = problem.residuals(x);
      const double cost = 0.5 * next.squaredNorm(), gain = (result.cost - cost) / predicted;
      if (std::isfinite(cost) && predicted > 0.0 && gain > least_gain) {
        const double decrease = (result.cost - cost) / result.cost;
        result.x = std::move(x);
        residuals = std::move(next);
        result.cost = cost;
        damping *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3.0));
        growth = 2.0;
        model.set(result.x, residuals, bounds);
        if (decrease <= options.cost_tolerance) {
          result.history.push_back({iteration + 1, cost, model.gradient()});
          return end(Stop::cost, fmt::format("The cost falls by less than {:.1e} of itself.", options.cost_tolerance));
        }
        break;
      }
      if (predicted <= rounding_of_cost * result.cost)
        return end(Stop::cost, "The cost cannot fall by more than its rounding.");
      if (!shorten()) return end(Stop::stuck, stuck);
    }
  }
}

}  // namespace springnet::learning
