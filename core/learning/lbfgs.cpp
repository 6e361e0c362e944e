#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "learning/course.hpp"
#include "learning/minimise.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index most_pairs = 10;
constexpr double least_wolfe_gain = 1e-4, most_slope = 0.9;  // Wolfe's conditions, of the decrease and of the slope
constexpr int most_trials = 40;                              // of a line search

// Of the cost by the variables in their units: B = theta I - W M W^T, from the last steps and changes of the gradient.
class Curvature {
 public:
  explicit Curvature(Index variables) : steps_(variables, 0), changes_(variables, 0) {}

  [[nodiscard]] bool is_set() const noexcept { return theta_ > 0.0; }
  [[nodiscard]] bool has_pairs() const noexcept { return steps_.cols() > 0; }
  // The same in all directions.
  void set(double theta) {
    theta_ = theta;
    steps_.resize(Eigen::NoChange, 0);
    changes_.resize(Eigen::NoChange, 0);
    set_matrices();
  }
  // Leaves out a pair that would make B indefinite, and forgets all if the matrices are lost to rounding.
  void add(const VectorXd& step, const VectorXd& change) {
    const double product = step.dot(change), square = change.squaredNorm();
    if (!(product > std::numeric_limits<double>::epsilon() * square)) return;
    const Index kept = std::min(steps_.cols(), most_pairs - 1);
    for (auto [list, last] : {std::pair(&steps_, &step), std::pair(&changes_, &change)}) {
      MatrixXd next(list->rows(), kept + 1);
      next.leftCols(kept) = list->rightCols(kept);
      next.col(kept) = *last;
      *list = std::move(next);
    }
    theta_ = square / product;
    set_matrices();
    if (!m_.allFinite()) set(theta_);
  }
  void archive(Archive& archive) {
    archive.number(theta_);
    auto pairs = static_cast<std::uint64_t>(steps_.cols());
    archive.below(pairs, static_cast<std::uint64_t>(most_pairs) + 1, "a number of steps");
    for (MatrixXd* const each : {&steps_, &changes_}) {
      each->resize(Eigen::NoChange, static_cast<Index>(pairs));
      archive.numbers(each->data(), static_cast<std::size_t>(each->size()));
    }
    if (archive.reads()) set_matrices();
  }

  // Of the quadratic model with this gradient.
  [[nodiscard]] double change(const VectorXd& step, const VectorXd& gradient) const {
    const VectorXd product = w_.transpose() * step;
    return gradient.dot(step) + 0.5 * (theta_ * step.squaredNorm() - product.dot(m_ * product));
  }
  // The first minimum of the quadratic model on the way down the gradient that bounds bend, the paper's algorithm CP.
  // `along`: W^T (the way).
  [[nodiscard]] VectorXd cauchy_point(const VectorXd& u, const VectorXd& gradient, const Scaled& bounds,
                                      VectorXd& along) const;
  // The minimum of the model from there over the variables that it leaves free, without bounds: the change of u.
  [[nodiscard]] VectorXd subspace_step(const VectorXd& u, const VectorXd& gradient, const Scaled& bounds,
                                       const VectorXd& from, const VectorXd& along) const;

 private:
  void set_matrices() {
    const Index pairs = steps_.cols();
    w_.resize(steps_.rows(), 2 * pairs);
    w_.leftCols(pairs) = changes_;
    w_.rightCols(pairs) = theta_ * steps_;
    const MatrixXd products = steps_.transpose() * changes_;
    const MatrixXd below = products.triangularView<Eigen::StrictlyLower>();
    MatrixXd inverse(2 * pairs, 2 * pairs);
    inverse.topLeftCorner(pairs, pairs) = -MatrixXd(products.diagonal().asDiagonal());
    inverse.bottomLeftCorner(pairs, pairs) = below;
    inverse.topRightCorner(pairs, pairs) = below.transpose();
    inverse.bottomRightCorner(pairs, pairs) = theta_ * (steps_.transpose() * steps_);
    m_ = pairs > 0 ? MatrixXd(inverse.fullPivLu().inverse()) : inverse;
  }

  double theta_ = 0.0;
  MatrixXd steps_, changes_;  // of u and of the gradient, a column each, the last one last
  MatrixXd w_, m_;
};

VectorXd Curvature::cauchy_point(const VectorXd& u, const VectorXd& gradient, const Scaled& bounds,
                                 VectorXd& along) const {
  struct Bend {
    double at;
    Index variable;
  };
  std::vector<Bend> bends;
  VectorXd direction = -gradient, point = u;
  for (Index k = 0; k < u.size(); ++k) {
    double at = std::numeric_limits<double>::infinity();
    if (gradient[k] < 0.0) at = (u[k] - bounds.upper()[k]) / gradient[k];
    if (gradient[k] > 0.0) at = (u[k] - bounds.lower()[k]) / gradient[k];
    if (at <= 0.0) direction[k] = 0.0;
    if (at > 0.0 && std::isfinite(at)) bends.push_back({at, k});
  }
  std::stable_sort(bends.begin(), bends.end(), [](const Bend& a, const Bend& b) { return a.at < b.at; });
  VectorXd product = w_.transpose() * direction;
  along = VectorXd::Zero(product.size());
  double slope = -direction.squaredNorm(), curvature = -theta_ * slope - product.dot(m_ * product), at = 0.0;
  for (const Bend& bend : bends) {
    const double until = bend.at - at;
    if (!(slope < 0.0) || (curvature > 0.0 && -slope / curvature < until)) break;
    const Index k = bend.variable;
    point[k] = direction[k] > 0.0 ? bounds.upper()[k] : bounds.lower()[k];
    along += until * product;
    const double own = gradient[k];
    const VectorXd row = w_.row(k).transpose();
    slope += until * curvature + own * own + theta_ * own * (point[k] - u[k]) - own * row.dot(m_ * along);
    curvature -= theta_ * own * own + 2.0 * own * row.dot(m_ * product) + own * own * row.dot(m_ * row);
    product += own * row;
    direction[k] = 0.0;
    at = bend.at;
  }
  const double rest = slope < 0.0 && curvature > 0.0 ? -slope / curvature : 0.0;
  for (Index k = 0; k < u.size(); ++k)
    if (direction[k] != 0.0) point[k] = u[k] + (at + rest) * direction[k];
  along += rest * product;
  return bounds.within(point);
}

VectorXd Curvature::subspace_step(const VectorXd& u, const VectorXd& gradient, const Scaled& bounds,
                                  const VectorXd& from, const VectorXd& along) const {
  std::vector<Index> free;
  for (Index k = 0; k < u.size(); ++k)
    if (from[k] > bounds.lower()[k] && from[k] < bounds.upper()[k]) free.push_back(k);
  VectorXd result = VectorXd::Zero(u.size());
  const VectorXd all = gradient + theta_ * (from - u) - w_ * (m_ * along);
  MatrixXd w(static_cast<Index>(free.size()), w_.cols());
  VectorXd reduced(static_cast<Index>(free.size()));
  for (std::size_t j = 0; j < free.size(); ++j) {
    w.row(static_cast<Index>(j)) = w_.row(free[j]);
    reduced[static_cast<Index>(j)] = all[free[j]];
  }
  VectorXd step = -reduced / theta_;
  if (has_pairs()) {  // Sherman, Morrison and Woodbury
    const MatrixXd small = MatrixXd::Identity(w_.cols(), w_.cols()) - m_ * (w.transpose() * w) / theta_;
    step -= w * small.fullPivLu().solve(m_ * (w.transpose() * reduced)) / (theta_ * theta_);
  }
  for (std::size_t j = 0; j < free.size(); ++j) result[free[j]] = step[static_cast<Index>(j)];
  return result;
}

// The greatest share of a step that stays within the bounds.
double room(const VectorXd& u, const VectorXd& step, const Scaled& bounds) {
  double share = std::numeric_limits<double>::infinity();
  for (Index k = 0; k < u.size(); ++k) {
    if (step[k] > 0.0) share = std::min(share, (bounds.upper()[k] - u[k]) / step[k]);
    if (step[k] < 0.0) share = std::min(share, (bounds.lower()[k] - u[k]) / step[k]);
  }
  return std::max(0.0, share);
}

struct LbfgsState : SearchState {
  explicit LbfgsState(Index variables) : curvature(variables) {}
  Curvature curvature;
  double sensitivity = 0.0;  // see Scaled; 0: not known yet
  void archive(Archive& archive) {
    SearchState::archive(archive);
    curvature.archive(archive);
    archive.number(sensitivity);
  }
};

struct Point {
  VectorXd x, residuals, gradient;
  double cost = 0.0;
};

class LineSearch {
 public:
  LineSearch(LeastSquares& problem, const Scaled& scaled) : problem_(problem), scaled_(scaled) {}

  [[nodiscard]] Point at(const VectorXd& x) {
    Point point{x, problem_.residuals(x), {}, 0.0};
    point.cost = 0.5 * point.residuals.squaredNorm();
    return point;
  }
  void differentiate(Point& point) const { point.gradient = scaled_.gradient(problem_, point.x, point.residuals); }

  // Towards the minimum of the model within the bounds: the way to its minimum without bounds that is projected onto
  // them, or else cut at the first one. Each lowers the model as much as the Cauchy point, which the search needs to
  // converge.
  [[nodiscard]] VectorXd direction(const Curvature& curvature, const VectorXd& u, const VectorXd& gradient) const {
    VectorXd along;
    const VectorXd cauchy = curvature.cauchy_point(u, gradient, scaled_, along);
    const VectorXd step = curvature.subspace_step(u, gradient, scaled_, cauchy, along);
    const VectorXd first = cauchy - u, projected = scaled_.within(cauchy + step) - u;
    const double change = curvature.change(first, gradient);
    if (curvature.change(projected, gradient) <= change) return projected;
    const VectorXd cut = scaled_.within(cauchy + std::min(1.0, room(cauchy, step, scaled_)) * step) - u;
    return curvature.change(cut, gradient) <= change ? cut : first;
  }

  // A point down this direction: a step that is too long is shortened until the cost falls enough, one after which it
  // still falls steeply is lengthened. None: the cost falls nowhere.
  [[nodiscard]] std::optional<Point> search(const Point& from, const VectorXd& direction) {
    const VectorXd u = scaled_.u_of(from.x);
    const double slope = from.gradient.dot(direction), most = std::max(1.0, room(u, direction, scaled_));
    double share = 1.0;
    bool was_too_long = false;
    std::optional<Point> best;
    for (int trial = 0; trial < most_trials; ++trial) {
      Point next = at(scaled_.x_of(scaled_.within(u + share * direction)));
      if (!std::isfinite(next.cost) || next.cost > from.cost + least_wolfe_gain * share * slope) {
        if (best) return best;
        was_too_long = true;
        // The minimum of the parabola through both costs with this slope.
        const double parabola = -0.5 * slope * share * share / (next.cost - from.cost - slope * share);
        share = std::isfinite(parabola) ? std::clamp(parabola, 0.1 * share, 0.5 * share) : 0.25 * share;
        continue;
      }
      if (best && best->cost <= next.cost) return best;
      differentiate(next);
      best = std::move(next);
      if (was_too_long || share >= most || best->gradient.dot(direction) >= most_slope * slope) return best;
      share = std::min(2.0 * share, most);
    }
    return best;
  }

 private:
  LeastSquares& problem_;
  const Scaled& scaled_;
};

}  // namespace

Minimum lbfgs(LeastSquares& problem, const VectorXd& start, const Bounds& bounds, const MinimiseOptions& options) {
  check_start(start, bounds, options);
  const Scaled scaled(bounds, options);
  LineSearch search(problem, scaled);
  LbfgsState state(start.size());
  state.x = start;
  take_up(state, options);
  Point now = search.at(state.x);
  static_cast<void>(cost_at_start(now.residuals));
  search.differentiate(now);
  if (!state.curvature.is_set()) {
    state.sensitivity = scaled.sensitivity(problem, now.gradient.cwiseQuotient(scaled.unit()));
    state.curvature.set(state.sensitivity * state.sensitivity);
  }
  const Course course(options);
  while (true) {
    keep(state, options);
    if (const auto ended =
            course.ends(state, now.cost, scaled.greatest(now.x, now.gradient, now.cost, state.sensitivity)))
      return *ended;
    const VectorXd u = scaled.u_of(now.x);
    while (true) {
      const VectorXd direction = search.direction(state.curvature, u, now.gradient);
      const double slope = now.gradient.dot(direction);
      if (direction.norm() <= options.step_tolerance * u.norm()) return course.end_by_step(state, now.cost);
      if (-slope <= rounding_of_cost * now.cost) return course.end_by_rounding(state, now.cost);
      std::optional<Point> next = search.search(now, direction);
      if (next) {
        state.curvature.add(scaled.u_of(next->x) - u, next->gradient - now.gradient);
        course.go_on(state, next->x, now.cost, next->cost);
        now = std::move(*next);
        break;
      }
      // What earlier steps told of the curvature may be wrong here.
      if (!state.curvature.has_pairs()) return course.end_stuck(state, now.cost);
      state.curvature.set(state.sensitivity * state.sensitivity);
    }
  }
}

}  // namespace springnet::learning
