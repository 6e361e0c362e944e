#include <cmath>
#include <utility>

#include "learning/course.hpp"
#include "learning/minimise.hpp"

namespace springnet::learning {

namespace {

using Eigen::VectorXd;

constexpr double momentum = 0.9;
constexpr double growth = 1.1, cut = 0.5;    // of the rate, after a step that was made, or not
constexpr double least_descent_gain = 1e-4;  // of the decrease that the gradient predicts
constexpr int small_decreases = 10;          // momentum leads past a minimum and back

struct DescentState : SearchState {
  VectorXd step;             // the last one, in units of the variables
  double rate = 0.0;         // of the gradient
  double sensitivity = 0.0;  // see Scaled; 0: not known yet
  void archive(Archive& archive) {
    SearchState::archive(archive);
    archive_numbers(archive, step, "steps of a search");
    archive.number(rate);
    archive.number(sensitivity);
  }
};

}  // namespace

Minimum gradient_descent(LeastSquares& problem, const VectorXd& start, const Bounds& bounds,
                         const MinimiseOptions& options) {
  check_start(start, bounds, options);
  const Scaled scaled(bounds, options);
  DescentState state;
  state.x = start;
  state.step = VectorXd::Zero(start.size());
  take_up(state, options);
  VectorXd residuals = problem.residuals(state.x);
  double cost = cost_at_start(residuals);
  VectorXd gradient = scaled.gradient(problem, state.x, residuals);
  if (state.sensitivity == 0.0) {
    state.sensitivity = scaled.sensitivity(problem, gradient.cwiseQuotient(scaled.unit()));
    state.rate = 1.0 / (state.sensitivity * state.sensitivity);
  }
  const Course course(options, small_decreases);
  while (true) {
    keep(state, options);
    if (const auto ended = course.ends(state, cost, scaled.greatest(state.x, gradient, cost, state.sensitivity)))
      return *ended;
    const VectorXd u = scaled.u_of(state.x);
    while (true) {
      const bool has_momentum = !state.step.isZero(0.0);
      const VectorXd next = scaled.within(u + momentum * state.step - state.rate * gradient), step = next - u;
      const double predicted = -gradient.dot(step);
      if (predicted <= 0.0 && has_momentum) {  // it leads upwards
        state.step.setZero();
        continue;
      }
      if (step.norm() <= options.step_tolerance * u.norm()) return course.end_by_step(state, cost);
      VectorXd x = scaled.x_of(next), found = problem.residuals(x);
      const double next_cost = 0.5 * found.squaredNorm();
      if (std::isfinite(next_cost) && cost - next_cost >= least_descent_gain * predicted && next_cost < cost) {
        course.go_on(state, std::move(x), cost, next_cost);
        state.step = step;
        state.rate *= growth;
        residuals = std::move(found);
        cost = next_cost;
        gradient = scaled.gradient(problem, state.x, residuals);
        break;
      }
      if (predicted <= rounding_of_cost * cost) return course.end_by_rounding(state, cost);
      state.step.setZero();
      state.rate *= cut;
      if (!(state.rate > 0.0)) return course.end_stuck(state, cost);
    }
  }
}

}  // namespace springnet::learning
