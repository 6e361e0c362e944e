#include "learning/course.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet::learning {

using Eigen::Index;
using Eigen::VectorXd;
using Stop = Minimum::Stop;

void archive_numbers(Archive& archive, VectorXd& values, const char* what) {
  archive.same(static_cast<std::uint64_t>(values.size()), what);
  archive.numbers(values.data(), static_cast<std::size_t>(values.size()));
}

void archive_history(Archive& archive, std::vector<Progress>& history) {
  history.resize(archive.count(history.size(), sizeof(int) + 3 * sizeof(double), "iterations of a search"));
  for (Progress& each : history) {
    archive.number(each.iteration);
    archive.number(each.cost);
    archive.number(each.gradient);
    archive.number(each.aside);
  }
}

void SearchState::archive(Archive& archive) {
  archive.number(iteration);
  archive.number(small_decreases);
  archive_numbers(archive, x, "variables of a search");
  archive_history(archive, history);
}

void check_start(const VectorXd& start, const Bounds& bounds, const MinimiseOptions& options) {
  if (bounds.lower.size() != start.size() || bounds.upper.size() != start.size())
    throw Error(ErrorKind::input, fmt::format("a search of {} variables has {} lower and {} upper bounds", start.size(),
                                              bounds.lower.size(), bounds.upper.size()));
  if (options.unit.size() != 0 && (options.unit.size() != start.size() || !(options.unit.minCoeff() > 0.0)))
    throw Error(ErrorKind::input, fmt::format("a search of {} variables has {} units; each must be above 0",
                                              start.size(), options.unit.size()));
  for (Index k = 0; k < start.size(); ++k)
    if (!(bounds.lower[k] <= start[k] && start[k] <= bounds.upper[k]) || !std::isfinite(start[k]))
      throw Error(ErrorKind::input, fmt::format("variable {} starts at {}, which is not within {} and {}", k, start[k],
                                                bounds.lower[k], bounds.upper[k]));
}

double cost_at_start(const VectorXd& residuals) {
  const double cost = 0.5 * residuals.squaredNorm();
  if (!std::isfinite(cost))
    throw Error(ErrorKind::input, "the search starts where residuals are not finite; start from other values");
  return cost;
}

bool is_held(const VectorXd& x, const VectorXd& gradient, const Bounds& bounds, Index variable) {
  const double own = x[variable], slope = gradient[variable];
  const double lower = bounds.lower[variable], upper = bounds.upper[variable];
  return lower == upper || (own <= lower && slope > 0.0) || (own >= upper && slope < 0.0);
}

std::optional<Minimum> Course::ends(SearchState& state, double cost, double gradient) const {
  const Progress now{state.iteration, cost, gradient, options_.aside ? options_.aside(state.x) : 0.0};
  state.history.push_back(now);
  if (options_.on_iteration && !options_.on_iteration(now, state.x))
    return end(state, cost, Stop::asked, "It was stopped; the values are the best until then.");
  if (!(gradient > options_.gradient_tolerance))
    return end(state, cost, Stop::gradient,
               fmt::format("The gradient is {:.1e} of what it could be, at most {:.1e}.", gradient,
                           options_.gradient_tolerance));
  if (state.small_decreases >= most_small_decreases_)
    return end(state, cost, Stop::cost,
               fmt::format("The cost falls by less than {:.1e} of itself.", options_.cost_tolerance));
  if (state.iteration >= options_.max_iterations)
    return end(state, cost, Stop::iterations,
               fmt::format("All {} iterations were made; more may find better values.", state.iteration));
  return std::nullopt;
}

void Course::go_on(SearchState& state, VectorXd x, double cost_before, double cost) const {
  state.x = std::move(x);
  ++state.iteration;
  const bool is_small = cost_before - cost <= options_.cost_tolerance * cost_before;
  state.small_decreases = is_small ? state.small_decreases + 1 : 0;
}

Minimum Course::end(const SearchState& state, double cost, Stop stop, std::string reason) const {
  return {state.x, cost, stop, std::move(reason), state.history};
}

Minimum Course::end_by_step(const SearchState& state, double cost) const {
  return end(state, cost, Stop::step,
             fmt::format("Steps are shorter than {:.1e} of the values.", options_.step_tolerance));
}

Minimum Course::end_by_rounding(const SearchState& state, double cost) const {
  return end(state, cost, Stop::cost, "The cost cannot fall by more than its rounding.");
}

Minimum Course::end_stuck(const SearchState& state, double cost) const {
  return end(state, cost, Stop::stuck,
             "No step lowers the cost, however short; the motion may fail at the values nearby.");
}

Scaled::Scaled(const Bounds& bounds, const MinimiseOptions& options)
    : bounds_(bounds),
      unit_(options.unit.size() > 0 ? options.unit : VectorXd::Ones(bounds.lower.size())),
      lower_(u_of(bounds.lower)),
      upper_(u_of(bounds.upper)) {}

VectorXd Scaled::x_of(const VectorXd& u) const {
  VectorXd x = u.cwiseProduct(unit_);
  for (Index k = 0; k < x.size(); ++k) {
    if (u[k] <= lower_[k])
      x[k] = bounds_.lower[k];
    else if (u[k] >= upper_[k])
      x[k] = bounds_.upper[k];
    else
      x[k] = std::clamp(x[k], bounds_.lower[k], bounds_.upper[k]);
  }
  return x;
}

VectorXd Scaled::gradient(LeastSquares& problem, const VectorXd& x, const VectorXd& residuals) const {
  problem.linearise(x);
  return problem.transposed_times(residuals).cwiseProduct(unit_);
}

double Scaled::sensitivity(LeastSquares& problem, const VectorXd& by_x) const {
  const VectorXd by_u = by_x.cwiseProduct(unit_);
  const double size = by_u.norm();
  if (!(size > 0.0)) return 1.0;
  const double change = problem.times(by_u.cwiseProduct(unit_) / size).norm();
  return change > 0.0 ? change : 1.0;
}

double Scaled::greatest(const VectorXd& x, const VectorXd& by_u, double cost, double sensitivity) const {
  double greatest = 0.0;
  for (Index k = 0; k < x.size(); ++k)
    if (!is_held(x, by_u, bounds_, k)) greatest = std::max(greatest, std::abs(by_u[k]));
  return cost > 0.0 ? greatest / (sensitivity * std::sqrt(2.0 * cost)) : 0.0;
}

}  // namespace springnet::learning
