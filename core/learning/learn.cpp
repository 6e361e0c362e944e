#include <springnet/learn.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/certainty.hpp"
#include "learning/fit.hpp"
#include "learning/fit_quality.hpp"
#include "learning/guess_search.hpp"
#include "learning/held_out.hpp"
#include "learning/learned_values.hpp"
#include "learning/many_variables.hpp"
#include "learning/minimise.hpp"
#include "learning/notes.hpp"
#include "learning/result.hpp"
#include "learning/same_object.hpp"
#include "learning/search.hpp"
#include "learning/search_journal.hpp"
#include "learning/several_starts.hpp"
#include "text/counted.hpp"

namespace springnet {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Up to so many variables sensitivities are known as a whole, for intervals and what is not determined.
constexpr Eigen::Index most_with_intervals = 2000;

// What was observed in this share of the time; empty: of an experiment nothing.
std::vector<Experiment> first_part(const std::vector<Experiment>& experiments, double share) {
  std::vector<Experiment> result;
  for (const Experiment& each : experiments) {
    const std::vector<double> all = each.observations.times();
    const double until = share * all.back();
    if (!(until > 0.0) || all.front() > until) return {};
    Experiment part{each.network, each.options, learning::part_of(each.observations, 0.0, until), {}, each.name};
    result.push_back(std::move(part));
  }
  return result;
}

// How far the search would go on with the motion of half the time step, to first order; no size: that motion fails.
VectorXd shift_by_half_step(const std::vector<Experiment>& experiments,
                            const std::shared_ptr<const PluginHost>& plugins, const std::vector<Learnable>& learnables,
                            const learning::Certainty& certainty, const VectorXd& scale, const VectorXd& x,
                            const VectorXd& residuals, const LearnOptions& options, std::vector<std::string>& notes) {
  try {
    learning::Fit half(learning::with_half_the_step(experiments), plugins, learnables, 0.0, options.threads,
                       options.memory);
    const VectorXd other = half.observed_residuals(x);
    if (other.allFinite()) return certainty.change_for(other - residuals).cwiseProduct(scale);
    notes.push_back("How far half the time step would move the values is not known: " + half.why_failed());
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::plugin) throw;
    notes.push_back(std::string("How far half the time step would move the values is not known: ") + error.what());
  }
  return {};
}

// What is known of the values beforehand is in the units of the observations' noise, if that is known.
LearnedNet learn_with_widths(const std::vector<Experiment>& experiments,
                             const std::shared_ptr<const PluginHost>& plugins, std::vector<Learnable> learnables,
                             LearnOptions options) {
  const bool have_widths = std::any_of(learnables.begin(), learnables.end(),
                                       [](const Learnable& each) { return !each.guess_widths.empty(); });
  const bool can_compare = !learning::have_plain_weights(learning::learned_from(experiments));
  options.guess_rule = GuessRule::given;
  options.guess_weight = have_widths && can_compare ? 1.0 : 0.0;
  constexpr double nothing_known = 100.0;  // a guess that is this far off holds nothing
  for (Learnable& each : learnables) {
    if (options.guess_weight == 0.0) continue;
    // Of all values together: what is known of each adds up.
    const double width = nothing_known * std::sqrt(static_cast<double>(learning::value_count(each)));
    if (each.guess_widths.empty()) each.guess_widths.assign(learning::value_count(each), width);
    std::replace(each.guess_widths.begin(), each.guess_widths.end(), 0.0, width);
  }
  LearnedNet result = learn(experiments, plugins, learnables, options);
  const char* const note = can_compare
                               ? "First guesses hold values by their widths, beside the standard deviations of the "
                                 "observations (weight 1)."
                               : "First guesses have widths, but the observations no standard deviations to compare "
                                 "them with: the guesses hold nothing (weight 0). Give the tables columns 's', or "
                                 "choose the weight by the L-curve.";
  if (have_widths) result.notes.emplace_back(note);
  return result;
}

// Along what the data do not determine a search may have moved variables without effect; they are back at the start
// where all that was observed stays as it is.
VectorXd without_idle_moves(learning::Fit& fit, const learning::Certainty& certainty, const VectorXd& x,
                            const VectorXd& residuals) {
  if (fit.guess_weight() > 0.0 || fit.minds_smoothness() || certainty.undetermined() == 0) return x;
  const learning::Variables& variables = fit.variables();
  const VectorXd& scale = variables.scale();
  const VectorXd back =
      variables.start() + scale.cwiseProduct(certainty.with_influence((x - variables.start()).cwiseQuotient(scale)));
  if ((back.array() < variables.lower().array()).any() || (back.array() > variables.upper().array()).any()) return x;
  constexpr double as_good = 1e-9;
  const double norm = fit.observed_residuals(back).norm();
  return norm <= (1.0 + as_good) * residuals.norm() + fit.unseen() ? back : x;
}

// What the data say of the values x.
void describe_what_is_known(const std::vector<Experiment>& experiments,
                            const std::shared_ptr<const PluginHost>& plugins, const std::vector<Learnable>& learnables,
                            const LearnOptions& options, learning::Fit& fit, learning::Judge& judge, const VectorXd& x,
                            const VectorXd& residuals, LearnedNet& result) {
  const learning::Variables& variables = fit.variables();
  const VectorXd& scale = variables.scale();
  const double numbers = static_cast<double>(variables.count()) * static_cast<double>(fit.observation_rows());
  if (result.stopped || variables.count() > most_with_intervals || numbers > learning::MinimiseOptions{}.most_numbers) {
    result.notes.push_back(
        result.stopped
            ? "Intervals and what the data determine are not known, as it was stopped."
            : fmt::format("Intervals and what the data determine are told for up to {} variables, and {:g} for the "
                          "product with the observed values; these are {} and {:g}.",
                          most_with_intervals, learning::MinimiseOptions{}.most_numbers, variables.count(), numbers));
    learning::describe(result, variables, x, nullptr, {});
    if (!result.stopped) learning::describe_many(result, fit, options.certainty_products);
    return;
  }
  const MatrixXd jacobian = fit.observed_times(MatrixXd(scale.asDiagonal()));
  const learning::Certainty certainty(jacobian, residuals, fit.observed(), fit.guess_weight(), fit.unseen(),
                                      fit.minds_smoothness());
  result.singular_values = certainty.singular_values();
  result.undetermined = certainty.undetermined();
  const VectorXd shift =
      shift_by_half_step(experiments, plugins, learnables, certainty, scale, x, residuals, options, result.notes);
  const VectorXd kept = without_idle_moves(fit, certainty, x, residuals);
  if (kept != x) {
    result.values = variables.values(kept);
    judge.judge(kept, result);
  }
  if (shift.size() > 0) judge.judge_half_step(kept + shift, result);
  learning::describe(result, variables, kept, &certainty, shift);
  if (result.observed + result.undetermined <= result.variables)
    result.notes.push_back(fmt::format("{} for {} leave nothing to tell the noise from: there are no intervals.",
                                       counted(result.observed, "observed value"),
                                       counted(result.variables - result.undetermined, "determined variable")));
}

}  // namespace

LearnedNet learn(const std::vector<Experiment>& all_experiments, const std::shared_ptr<const PluginHost>& plugins,
                 const std::vector<Learnable>& learnables, const LearnOptions& options) {
  if (!plugins) throw Error(ErrorKind::input, "learning: there is no plugin host");
  if (options.guess_rule == GuessRule::widths) return learn_with_widths(all_experiments, plugins, learnables, options);
  learning::check_starts(options);
  learning::Judge judge(all_experiments, plugins, learnables, options);
  const std::vector<Experiment> experiments = learning::learned_from(all_experiments);
  const bool by_rule = options.guess_rule != GuessRule::given;
  if (options.guess_rule == GuessRule::discrepancy && learning::have_plain_weights(experiments))
    throw Error(ErrorKind::input,
                "learning: the discrepancy rule compares differences with standard deviations, but all weights are 1; "
                "give the observations standard deviations, or take the L-curve");
  learning::Fit fit(experiments, plugins, learnables, by_rule ? 0.0 : options.guess_weight, options.threads,
                    options.memory);
  fit.set_smoothness(options.smoothness);
  const learning::Variables& variables = fit.variables();
  LearnedNet result;
  learning::SearchJournal journal(learning::identity_of(experiments, *plugins, learnables, options), options.state);
  learning::Search search{options, variables, journal, result.history};
  result.start_cost = 0.5 * fit.residuals(variables.start()).squaredNorm();
  if (!std::isfinite(result.start_cost))
    throw Error(ErrorKind::input,
                "learning: the squares of the differences at the start are not finite: " +
                    (fit.why_failed().empty() ? "a value that was observed is too large" : fit.why_failed()));
  search.stages = std::max(1, options.stages);
  fit.count_in(search.work);
  double stage_weight = options.guess_weight, greatest_weight = 0.0;
  if (by_rule) {
    fit.linearise(variables.start());
    constexpr Eigen::Index products = 8;  // enough for the size of the greatest value
    const VectorXd greatest = learning::singular_values(fit, {products, 1, 1e-2}).values;
    greatest_weight = greatest.size() > 0 ? greatest[0] * greatest[0] : 1.0;
    // In units of standard deviations 1: values are known to a factor of e or so.
    stage_weight = options.guess_rule == GuessRule::discrepancy ? 1.0 : 1e-4 * greatest_weight;
  }
  bool weight_is_found = !by_rule;  // the first start finds it for all, so that their costs can be compared
  const auto search_from = [&](const VectorXd& first) {
    VectorXd start = first;
    // What a stage has found may be worse than the start for what it has not seen.
    const auto better = [&](learning::Fit& of) {
      const double cost = of.residuals(start).squaredNorm();
      if (!std::isfinite(cost) && !of.why_failed().empty() && result.notes.empty())
        result.notes.push_back(
            "With values from the first part of the motion more of it fails, so that the search went "
            "on from other ones: " +
            of.why_failed());
      return cost <= of.residuals(first).squaredNorm() ? start : first;
    };
    search.failure.clear();
    for (int stage = options.stages - 1; stage > 0 && !search.is_over(); --stage) {
      const double share = std::ldexp(1.0, -stage);
      const std::vector<Experiment> part = first_part(experiments, share);
      if (part.empty()) continue;
      learning::Fit fit_of_part(part, plugins, learnables, stage_weight, options.threads, options.memory);
      fit_of_part.set_smoothness(options.smoothness);
      fit_of_part.count_in(search.work);
      search.stage = search.stages - 1 - stage;
      start = search.run(fit_of_part, better(fit_of_part), share, false).x;
    }
    learning::Minimum found;
    found.x = better(fit);
    found.reason =
        search.stopped ? "It was stopped; the values are the best until then." : learning::ended_by(search.failure);
    found.cost = 0.5 * fit.residuals(found.x).squaredNorm();
    search.stage = search.stages - 1;
    if (search.is_over()) return found;
    if (weight_is_found) return search.run(fit, found.x, 1.0, true);
    learning::search_by_rule(search, fit, greatest_weight, result, found);
    stage_weight = fit.guess_weight();
    weight_is_found = true;
    return found;
  };
  learning::Minimum minimum = search_from(variables.start());
  result.failure = search.failure;
  if (options.starts > 1) minimum = learning::best_of_starts(fit, search, std::move(minimum), search_from, result);
  result.guess_weight = fit.guess_weight();

  result.parameters = learning::list_parameters(learnables);
  result.values = variables.values(minimum.x);
  result.observed = fit.observed();
  result.variables = static_cast<std::size_t>(variables.count());
  result.reason = minimum.reason;
  result.stopped = search.stopped;
  learning::describe_starts(result);
  result.cost = minimum.cost;
  result.smooth_cost = fit.smooth_cost(minimum.x);
  fit.linearise(minimum.x);
  const VectorXd residuals = fit.observed_residuals(minimum.x);
  result.rms = learning::rms_of(residuals, fit.observed());
  learning::judge_fit(experiments, residuals,
                      "try several starts (--starts 8), other or more parameters, a smaller time step, or observations "
                      "of a shorter time",
                      result);
  for (std::string& note : learning::notes_of_differences(experiments, learnables))
    result.notes.push_back(std::move(note));
  fit.note_events(result.notes);
  if (!fit.why_failed().empty() && options.starts == 1)
    result.notes.push_back("Motions that were tried at the end fail, and the search stepped back from there: " +
                           fit.why_failed());
  judge.judge(minimum.x, result);

  try {
    describe_what_is_known(experiments, plugins, learnables, options, fit, judge, minimum.x, residuals, result);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::plugin) throw;
    if (result.failure.empty()) result.failure = error.what();
    result.notes.push_back(std::string("Intervals and what the data determine are not known: ") + error.what());
    learning::describe(result, variables, minimum.x, nullptr, {});
  }
  learning::add_notes(result);
  return result;
}

VectorXd values_in(const std::shared_ptr<const Network>& network, const std::shared_ptr<const PluginHost>& plugins,
                   const std::vector<Learnable>& learnables) {
  learning::LearnedSets sets(*network, learning::values_of(learnables));
  Engine engine(*network, *plugins, {});
  sets.attach(engine);
  return sets.values_of(engine);
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
