#include "learning/search.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <springnet/error.hpp>

#include "learning/at_scope_end.hpp"

namespace springnet::learning {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class Problem final : public LeastSquares {
 public:
  explicit Problem(Fit& fit) : fit_(fit) {}
  VectorXd residuals(const VectorXd& x) override { return fit_.residuals(x); }
  void linearise(const VectorXd& x) override { fit_.linearise(x); }
  VectorXd times(const VectorXd& change) override { return fit_.times(change); }
  MatrixXd jacobian(Eigen::Index variables) override { return fit_.times(MatrixXd::Identity(variables, variables)); }
  VectorXd transposed_times(const VectorXd& weights) override { return fit_.transposed_times(weights); }

 private:
  Fit& fit_;
};

}  // namespace

std::string ended_by(const std::string& failure) {
  return "An error ended it, and the values are the best until then: " + failure;
}

Minimum Search::made(Fit& fit, const VectorXd& from, const MinimiseOptions& own) const {
  // A search that ends early needs no better derivatives.
  constexpr double share = 0.1, finest = 1e-10, coarsest = 1e-4;
  fit.set_accuracy(std::clamp(share * own.cost_tolerance, finest, coarsest));
  const AtScopeEnd exact([&fit] { fit.set_accuracy(finest); });
  Problem problem(fit);
  const Bounds bounds{variables.lower(), variables.upper()};
  switch (options.optimiser) {
    case Optimiser::lbfgs:
      return lbfgs(problem, from, bounds, own);
    case Optimiser::descent:
      return gradient_descent(problem, from, bounds, own);
    case Optimiser::levenberg_marquardt:
      break;
  }
  return levenberg_marquardt(problem, from, bounds, own);
}

Minimum Search::run(Fit& fit, const VectorXd& from, double share, bool is_last) {
  constexpr int most_of_a_stage = 30;
  constexpr double tolerance_of_a_stage = 1e-2, tolerance_of_a_weight = 1e-4;  // of the cost
  MinimiseOptions own;
  own.max_iterations = is_last ? options.max_iterations : std::min(most_of_a_stage, options.max_iterations);
  own.cost_tolerance = is_last ? options.tolerance : share < 1.0 ? tolerance_of_a_stage : tolerance_of_a_weight;
  // Of one that is known well, a small step hides larger ones of others: a coarse tolerance is of the cost alone.
  own.step_tolerance = own.gradient_tolerance = std::min(options.tolerance, LearnOptions{}.tolerance);
  own.unit = variables.scale();
  own.aside = [&fit](const VectorXd& x) { return fit.guess_cost(x) + fit.smooth_cost(x); };
  own.state = journal.present_leg();
  if (options.on_state) own.on_state = [this](const std::string& state) { options.on_state(journal.with(state)); };
  const double values = static_cast<double>(std::max<std::size_t>(1, fit.observed()));
  const int before = history.empty() ? 0 : history.back().iteration;
  const auto progress = [&](const Progress& now) {
    const double of_observations = std::max(0.0, now.cost - now.aside);
    LearnProgress told{before + now.iteration, share, now.cost, std::sqrt(2.0 * of_observations / values), {}};
    told.start = start;
    told.guess_weight = fit.guess_weight();
    const double of_leg = static_cast<double>(now.iteration) / std::max(1, own.max_iterations);
    told.done = (start + (stage + std::min(1.0, of_leg)) / stages) / std::max(1, options.starts);
    return told;
  };
  Minimum known{from, std::numeric_limits<double>::quiet_NaN(), Minimum::Stop::stuck, {}, {}};
  own.on_iteration = [&](const Progress& now, const VectorXd& best) {
    known.x = best;
    known.cost = now.cost;
    fit.forget_failure();  // what is told at the end is of the last iteration, also after --resume
    known.history.push_back(now);
    if (!options.on_iteration || stopped) return !stopped;
    LearnProgress told = progress(now);
    told.values = variables.values(best);
    told.work = work;
    stopped = !options.on_iteration(told);
    return !stopped;
  };
  Minimum minimum;
  if (std::optional<Minimum> ended = journal.ended_leg()) {
    minimum = std::move(*ended);
  } else {
    try {
      minimum = made(fit, from, own);
      if (!stopped) journal.end_leg(minimum);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::plugin || (start == 0 && known.x == variables.start())) throw;
      failure = error.what();
      if (std::isnan(known.cost)) known.cost = 0.5 * fit.residuals(known.x).squaredNorm();
      minimum = std::move(known);
      minimum.reason = ended_by(failure);
    }
  }
  for (const Progress& each : minimum.history) history.push_back(progress(each));
  return minimum;
}

}  // namespace springnet::learning
