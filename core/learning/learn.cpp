#include <springnet/learn.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/certainty.hpp"
#include "learning/fit.hpp"
#include "learning/learned_values.hpp"
#include "learning/minimise.hpp"
#include "learning/result.hpp"

namespace springnet {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Up to so many variables sensitivities are known as a whole, for intervals and what is not determined.
constexpr Eigen::Index most_with_intervals = 2000;

class Problem final : public learning::LeastSquares {
 public:
  explicit Problem(learning::Fit& fit) : fit_(fit) {}
  VectorXd residuals(const VectorXd& x) override { return fit_.residuals(x); }
  void linearise(const VectorXd& x) override { fit_.linearise(x); }
  VectorXd times(const VectorXd& change) override { return fit_.times(change); }
  MatrixXd jacobian(Eigen::Index variables) override { return fit_.times(MatrixXd::Identity(variables, variables)); }
  VectorXd transposed_times(const VectorXd& weights) override { return fit_.transposed_times(weights); }

 private:
  learning::Fit& fit_;
};

// What was observed in this share of the time; empty: of an experiment nothing.
std::vector<Experiment> first_part(const std::vector<Experiment>& experiments, double share) {
  std::vector<Experiment> result;
  for (const Experiment& each : experiments) {
    const std::vector<double> all = each.observations.times();
    const double until = share * all.back();
    if (!(until > 0.0) || all.front() > until) return {};
    Experiment part{each.network, each.options, {}};
    part.observations = learning::part_of(each.observations, 0.0, until);
    result.push_back(std::move(part));
  }
  return result;
}

// The stages of a search, told to the program as one.
struct Search {
  const LearnOptions& options;
  const learning::Variables& variables;
  std::vector<LearnProgress>& history;
  bool stopped = false;

  learning::Minimum run(learning::Fit& fit, const VectorXd& start, double share) {
    constexpr int most_of_a_stage = 30;
    constexpr double tolerance_of_a_stage = 1e-2;  // of the cost: the next stage goes on from there
    const bool is_last = share == 1.0;
    learning::MinimiseOptions own;
    own.max_iterations = is_last ? options.max_iterations : std::min(most_of_a_stage, options.max_iterations);
    own.cost_tolerance = is_last ? options.tolerance : tolerance_of_a_stage;
    own.step_tolerance = own.gradient_tolerance = options.tolerance;
    const double values = static_cast<double>(std::max<std::size_t>(1, fit.observed()));
    const int before = history.empty() ? 0 : history.back().iteration;
    own.on_iteration = [&, before](const learning::Progress& now, const VectorXd& best) {
      history.push_back({before + now.iteration, share, now.cost, std::sqrt(2.0 * now.cost / values), {}});
      if (!options.on_iteration || stopped) return !stopped;
      LearnProgress told = history.back();
      told.values = variables.values(best);
      stopped = !options.on_iteration(told);
      return !stopped;
    };
    Problem problem(fit);
    return learning::levenberg_marquardt(problem, start, {variables.lower(), variables.upper()}, own);
  }
};

std::vector<Experiment> with_half_the_step(std::vector<Experiment> experiments) {
  for (Experiment& each : experiments) each.options.time_step *= 0.5;
  return experiments;
}

// How far the search would go on with the motion of half the time step, to first order; no size: that motion fails.
VectorXd shift_by_half_step(const std::vector<Experiment>& experiments,
                            const std::shared_ptr<const PluginHost>& plugins, const std::vector<Learnable>& learnables,
                            const learning::Certainty& certainty, const VectorXd& scale, const VectorXd& x,
                            const VectorXd& residuals, std::size_t memory, std::vector<std::string>& notes) {
  try {
    learning::Fit half(with_half_the_step(experiments), plugins, learnables, 0.0, memory);
    const VectorXd other = half.residuals(x);
    if (other.allFinite()) return certainty.change_for(other - residuals).cwiseProduct(scale);
    notes.push_back("How far half the time step would move the values is not known: " + half.why_failed());
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::plugin) throw;
    notes.push_back(std::string("How far half the time step would move the values is not known: ") + error.what());
  }
  return {};
}

}  // namespace

LearnedNet learn(const std::vector<Experiment>& experiments, const std::shared_ptr<const PluginHost>& plugins,
                 const std::vector<Learnable>& learnables, const LearnOptions& options) {
  if (!plugins) throw Error(ErrorKind::input, "learning: there is no plugin host");
  learning::Fit fit(experiments, plugins, learnables, options.guess_weight, options.memory);
  const learning::Variables& variables = fit.variables();
  LearnedNet result;
  Search search{options, variables, result.history};
  result.start_cost = 0.5 * fit.residuals(variables.start()).squaredNorm();
  if (!std::isfinite(result.start_cost))
    throw Error(ErrorKind::input,
                "learning: the squares of the differences at the start are not finite: " +
                    (fit.why_failed().empty() ? "a value that was observed is too large" : fit.why_failed()));
  VectorXd start = variables.start();
  // What a stage has found may be worse than the start for what it has not seen.
  const auto better = [&](learning::Fit& of) {
    const double found = of.residuals(start).squaredNorm(), first = of.residuals(variables.start()).squaredNorm();
    return found <= first ? start : variables.start();
  };
  for (int stage = options.stages - 1; stage > 0 && !search.stopped; --stage) {
    const double share = std::ldexp(1.0, -stage);
    const std::vector<Experiment> first = first_part(experiments, share);
    if (first.empty()) continue;
    learning::Fit part(first, plugins, learnables, options.guess_weight, options.memory);
    start = search.run(part, better(part), share).x;
  }
  learning::Minimum minimum;
  minimum.x = better(fit);
  minimum.reason = "It was stopped; the values are the best until then.";
  minimum.cost = 0.5 * fit.residuals(minimum.x).squaredNorm();
  if (!search.stopped) minimum = search.run(fit, minimum.x, 1.0);

  result.parameters = learning::list_parameters(learnables);
  result.values = variables.values(minimum.x);
  result.observed = fit.observed();
  result.variables = static_cast<std::size_t>(variables.count());
  result.reason = minimum.reason;
  result.cost = minimum.cost;
  fit.linearise(minimum.x);
  const VectorXd residuals = fit.residuals(minimum.x).head(fit.observation_rows());
  result.rms = learning::rms_of(residuals, fit.observed());
  fit.note_ruptures(result.notes);

  const VectorXd& scale = variables.scale();
  const double numbers = static_cast<double>(variables.count()) * static_cast<double>(fit.observation_rows());
  if (search.stopped || variables.count() > most_with_intervals || numbers > learning::MinimiseOptions{}.most_numbers) {
    result.notes.push_back(
        search.stopped
            ? "Intervals and what the data determine are not known, as it was stopped."
            : fmt::format("Intervals and what the data determine are told for up to {} variables, and {:g} for the "
                          "product with the observed values; these are {} and {:g}.",
                          most_with_intervals, learning::MinimiseOptions{}.most_numbers, variables.count(), numbers));
    learning::describe(result, variables, minimum.x, nullptr, {});
    return result;
  }
  const MatrixXd jacobian = fit.times(MatrixXd(scale.asDiagonal())).topRows(fit.observation_rows());
  const learning::Certainty certainty(jacobian, residuals, fit.observed());
  result.singular_values = certainty.singular_values();
  result.undetermined = certainty.undetermined();
  const VectorXd shift = shift_by_half_step(experiments, plugins, learnables, certainty, scale, minimum.x, residuals,
                                            options.memory, result.notes);
  learning::describe(result, variables, minimum.x, &certainty, shift);
  return result;
}

Network with_values(const std::shared_ptr<const Network>& network, const std::shared_ptr<const PluginHost>& plugins,
                    const std::vector<Learnable>& learnables, const VectorXd& values) {
  const learning::LearnedSets sets(*network, learning::values_of(learnables));
  sets.check(values);
  Simulation simulation(network, plugins, {});
  sets.set(simulation, values);
  return simulation.present_network();
}

}  // namespace springnet
