#include <springnet/learn.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/certainty.hpp"
#include "learning/fit.hpp"
#include "learning/learned_values.hpp"
#include "learning/minimise.hpp"

namespace springnet {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

// Up to so many variables sensitivities are known as a whole, for intervals and what is not determined.
constexpr Eigen::Index most_with_intervals = 2000;

double rms_of(const VectorXd& residuals, std::size_t observed) {
  return observed > 0 ? std::sqrt(residuals.squaredNorm() / static_cast<double>(observed)) : 0.0;
}

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

// What was observed in [from, until], s.
Observations part_of(const Observations& all, double from, double until) {
  Observations part;
  part.files = all.files;
  const auto copy = [&](const auto& rows, auto& to) {
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(to),
                 [&](const auto& row) { return row.time >= from && row.time <= until; });
  };
  copy(all.positions, part.positions);
  copy(all.velocities, part.velocities);
  copy(all.distances, part.distances);
  return part;
}

// What was observed in this share of the time; empty: of an experiment nothing.
std::vector<Experiment> first_part(const std::vector<Experiment>& experiments, double share) {
  std::vector<Experiment> result;
  for (const Experiment& each : experiments) {
    const std::vector<double> all = each.observations.times();
    const double until = share * all.back();
    if (!(until > 0.0) || all.front() > until) return {};
    Experiment part{each.network, each.options, {}};
    part.observations = part_of(each.observations, 0.0, until);
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

// The parameters of the result, without what is known of them.
std::vector<LearnedParameter> list_parameters(const std::vector<Learnable>& learnables) {
  std::vector<LearnedParameter> result;
  for (const Learnable& each : learnables)
    for (const std::uint32_t member : each.values.members)
      for (int axis = 0; axis < (each.values.kind == Kind::initial_velocity ? 3 : 1); ++axis) {
        LearnedParameter parameter;
        parameter.kind = each.values.kind;
        parameter.of_elements = each.values.of_elements;
        parameter.parameter = each.values.parameter;
        parameter.member = member;
        parameter.axis = each.values.kind == Kind::initial_velocity ? axis : -1;
        result.push_back(std::move(parameter));
      }
  return result;
}

// How far the search would go on with the motion of half the time step, to first order; no size: that motion fails.
VectorXd shift_by_half_step(const std::vector<Experiment>& experiments,
                            const std::shared_ptr<const PluginHost>& plugins, const std::vector<Learnable>& learnables,
                            const learning::Certainty& certainty, const VectorXd& scale, const VectorXd& x,
                            const VectorXd& residuals, std::vector<std::string>& notes) {
  try {
    learning::Fit half(with_half_the_step(experiments), plugins, learnables, 0.0);
    const VectorXd other = half.residuals(x);
    if (other.allFinite()) return certainty.change_for(other - residuals).cwiseProduct(scale);
    notes.push_back("How far half the time step would move the values is not known: " + half.why_failed());
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::plugin) throw;
    notes.push_back(std::string("How far half the time step would move the values is not known: ") + error.what());
  }
  return {};
}

void describe(LearnedNet& learned, const learning::Variables& variables, const VectorXd& x,
              const learning::Certainty* certainty, const VectorXd& scale, const VectorXd& shift) {
  for (std::size_t k = 0; k < learned.parameters.size(); ++k) {
    LearnedParameter& each = learned.parameters[k];
    each.variable = variables.variable_of(k);
    const auto j = static_cast<Eigen::Index>(each.variable);
    each.start = variables.value_at(k, variables.start(), 0.0);
    each.value = variables.value_at(k, x, 0.0);
    each.at_bound = x[j] <= variables.lower()[j] || x[j] >= variables.upper()[j];
    const double infinite = std::numeric_limits<double>::infinity();
    const double width = certainty == nullptr ? infinite : certainty->half_width(j) * scale[j];
    const bool is_known = std::isfinite(width);  // else the bounds of the law would pass for an interval
    const double ends[] = {is_known ? variables.value_at(k, x, -width) : -infinite,
                           is_known ? variables.value_at(k, x, width) : infinite};
    each.lower = std::min(ends[0], ends[1]);
    each.upper = std::max(ends[0], ends[1]);
    each.determined = certainty == nullptr ? std::numeric_limits<double>::quiet_NaN() : certainty->determined(j);
    each.by_time_step = shift.size() == 0 ? std::numeric_limits<double>::quiet_NaN() : variables.slope(k, x) * shift[j];
  }
}

}  // namespace

LearnedNet learn(const std::vector<Experiment>& experiments, const std::shared_ptr<const PluginHost>& plugins,
                 const std::vector<Learnable>& learnables, const LearnOptions& options) {
  if (!plugins) throw Error(ErrorKind::input, "learning: there is no plugin host");
  learning::Fit fit(experiments, plugins, learnables, options.guess_weight);
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
    learning::Fit part(first, plugins, learnables, options.guess_weight);
    start = search.run(part, better(part), share).x;
  }
  learning::Minimum minimum;
  minimum.x = better(fit);
  minimum.reason = "It was stopped; the values are the best until then.";
  minimum.cost = 0.5 * fit.residuals(minimum.x).squaredNorm();
  if (!search.stopped) minimum = search.run(fit, minimum.x, 1.0);

  result.parameters = list_parameters(learnables);
  result.values = variables.values(minimum.x);
  result.observed = fit.observed();
  result.variables = static_cast<std::size_t>(variables.count());
  result.reason = minimum.reason;
  result.cost = minimum.cost;
  fit.linearise(minimum.x);
  const VectorXd residuals = fit.residuals(minimum.x).head(fit.observation_rows());
  result.rms = rms_of(residuals, fit.observed());

  const VectorXd& scale = fit.scale();
  const double numbers = static_cast<double>(variables.count()) * static_cast<double>(fit.observation_rows());
  if (search.stopped || variables.count() > most_with_intervals || numbers > learning::MinimiseOptions{}.most_numbers) {
    result.notes.push_back(
        search.stopped
            ? "Intervals and what the data determine are not known, as it was stopped."
            : fmt::format("Intervals and what the data determine are told for up to {} variables, and {:g} for the "
                          "product with the observed values; these are {} and {:g}.",
                          most_with_intervals, learning::MinimiseOptions{}.most_numbers, variables.count(), numbers));
    describe(result, variables, minimum.x, nullptr, scale, {});
    return result;
  }
  const MatrixXd jacobian = fit.times(MatrixXd(scale.asDiagonal())).topRows(fit.observation_rows());
  const learning::Certainty certainty(jacobian, residuals, fit.observed());
  result.singular_values = certainty.singular_values();
  result.undetermined = certainty.undetermined();
  const VectorXd shift =
      shift_by_half_step(experiments, plugins, learnables, certainty, scale, minimum.x, residuals, result.notes);
  describe(result, variables, minimum.x, &certainty, scale, shift);
  return result;
}

LearnedNet learn_online(const Experiment& experiment, const std::shared_ptr<const PluginHost>& plugins,
                        const std::vector<Learnable>& learnables, const OnlineOptions& options,
                        const std::function<bool(const LearnProgress&)>& on_step) {
  if (!plugins) throw Error(ErrorKind::input, "learning: there is no plugin host");
  learning::Fit fit({experiment}, plugins, learnables, 0.0);  // checks, and judges at the end
  const learning::Variables& variables = fit.variables();
  OnlineLearner learner(experiment.network, plugins, experiment.options, learnables, options);
  LearnedNet result;
  result.reason = "The motion was gone through once.";
  const double last = experiment.observations.times().back();
  constexpr double rounding = 1e-6;  // of a step
  const double slack = rounding * experiment.options.time_step;
  for (int step = 1; learner.time() < last - slack; ++step) {
    const double from = learner.time(), until = from + experiment.options.time_step + slack;
    const Observations seen = part_of(experiment.observations, step == 1 ? from : from + slack, until);
    const double cost = learner.step(seen), count = static_cast<double>(seen.value_count());
    if (!(count > 0.0)) continue;
    LearnProgress now{step, learner.time() / last, cost, std::sqrt(2.0 * cost / count), {}};
    result.history.push_back(now);
    now.values = learner.values();
    if (!on_step || on_step(now)) continue;
    result.reason = "It was stopped; the values are those until then.";
    break;
  }
  result.values = learner.values();
  result.observed = fit.observed();
  result.variables = static_cast<std::size_t>(variables.count());
  result.start_cost = 0.5 * fit.residuals(variables.start()).squaredNorm();
  const VectorXd residuals = fit.residuals(learner.variables());
  result.cost = 0.5 * residuals.squaredNorm();
  result.rms = rms_of(residuals, fit.observed());
  if (result.cost > result.start_cost)
    result.notes.emplace_back("The values at the end are worse than those at the start: learn more slowly (rate).");
  if (!residuals.allFinite()) result.notes.push_back("A motion with the values at the end fails: " + fit.why_failed());
  result.parameters = list_parameters(learnables);
  describe(result, variables, learner.variables(), nullptr, fit.scale(), {});
  return result;
}

Network with_values(const std::shared_ptr<const Network>& network, const std::shared_ptr<const PluginHost>& plugins,
                    const std::vector<Learnable>& learnables, const VectorXd& values) {
  std::vector<LearnedValues> all;
  for (const Learnable& each : learnables) all.push_back(each.values);
  const learning::LearnedSets sets(*network, std::move(all));
  sets.check(values);
  Simulation simulation(network, plugins, {});
  sets.set(simulation, values);
  return simulation.present_network();
}

}  // namespace springnet
