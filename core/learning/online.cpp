// The paper's learning while the net moves.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/learn.hpp>

#include "learning/fit.hpp"
#include "learning/fit_quality.hpp"
#include "learning/held_out.hpp"
#include "learning/notes.hpp"
#include "learning/observed_motion.hpp"
#include "learning/result.hpp"
#include "learning/variables.hpp"

namespace springnet {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void check(const OnlineOptions& options, const Network& network, Eigen::Index variables) {
  if (!(options.rate > 0.0 && options.rate <= 1.0))
    throw Error(ErrorKind::input, fmt::format("learning: the rate is {}, must be above 0 and at most 1", options.rate));
  // Positions and velocities of two states, in two orders.
  const double bytes =
      4.0 * 6.0 * sizeof(double) * static_cast<double>(network.nodes().size()) * static_cast<double>(variables);
  if (bytes > static_cast<double>(options.memory))
    throw Error(
        ErrorKind::input,
        fmt::format("learning: sensitivities of {} nodes by {} variables take {:.3g} GiB, more than {:.3g}; learn "
                    "values together, or from the whole motion, whose gradient needs no sensitivities",
                    network.nodes().size(), variables, bytes / (1 << 30),
                    static_cast<double>(options.memory) / (1 << 30)));
}

// What is known beforehand has no part in the paper's rule, whose steps are in units of the values themselves.
std::vector<Learnable> without_guesses(std::vector<Learnable> learnables) {
  for (Learnable& each : learnables) {
    each.guess_widths.clear();
    each.by_logarithm = false;
  }
  return learnables;
}

}  // namespace

struct OnlineLearner::Impl {
  Impl(const std::shared_ptr<const Network>& net, const std::shared_ptr<const PluginHost>& plugins,
       const SimulationOptions& simulation, const std::vector<Learnable>& learnables, const OnlineOptions& given)
      : options(given),
        nodes(net->nodes().size()),
        motion(net, plugins, simulation, simulation.time_step, learning::values_of(learnables)),
        observed_net(net, plugins, simulation, learning::values_of(learnables)),
        variables(*net, *plugins, without_guesses(learnables), motion.values_of_network()),
        x(variables.start()),
        values(variables.values(x)) {
    check(options, *net, variables.count());
    motion.begin_steps(values, changes());
  }

  // Of the values, for changes of the variables in units of their scale.
  [[nodiscard]] MatrixXd changes() const { return variables.times(x, MatrixXd(variables.scale().asDiagonal())); }

  double step(const Observations& seen) {
    const MatrixXd directions = changes();
    motion.make_step(values, directions);
    if (seen.times().empty()) return 0.0;
    check_observations(seen, nodes, motion.time(0), motion.time(1));
    learning::ObservedMotion observed(seen, {motion.time(0), motion.time(1)}, observed_net);
    VectorXd residuals = VectorXd::Zero(observed.count());
    observed.residuals(motion, values, residuals);
    MatrixXd jacobian = MatrixXd::Zero(observed.count(), variables.count()), positions, velocities;
    for (const std::size_t state : {std::size_t{0}, std::size_t{1}}) {
      motion.step_tangents(state, positions, velocities);
      observed.add_tangent(motion, state, {directions, positions, velocities}, jacobian);
    }
    greatest = std::max(greatest, jacobian.squaredNorm());
    if (greatest > 0.0) {
      // Differences that no change of the values by their own size explains are noise, or the model's: there the floor
      // shortens the step.
      const double floor = residuals.squaredNorm();
      x -= options.rate / (greatest + floor) * variables.scale().cwiseProduct(jacobian.transpose() * residuals);
      x = x.cwiseMax(variables.lower()).cwiseMin(variables.upper());
      values = variables.values(x);
    }
    return 0.5 * residuals.squaredNorm();
  }

  OnlineOptions options;
  std::size_t nodes;
  MotionDerivatives motion;
  learning::ObservedNet observed_net;
  learning::Variables variables;
  VectorXd x, values;
  double greatest = 0.0;  // square of the sensitivities of a step
};

OnlineLearner::OnlineLearner(const std::shared_ptr<const Network>& network,
                             const std::shared_ptr<const PluginHost>& plugins, const SimulationOptions& simulation,
                             const std::vector<Learnable>& learnables, const OnlineOptions& options) {
  if (!network) throw Error(ErrorKind::input, "learning: there is no network");
  impl_ = std::make_unique<Impl>(network, plugins, simulation, learnables, options);
}
OnlineLearner::~OnlineLearner() = default;
OnlineLearner::OnlineLearner(OnlineLearner&&) noexcept = default;
OnlineLearner& OnlineLearner::operator=(OnlineLearner&&) noexcept = default;
double OnlineLearner::step(const Observations& seen) { return impl_->step(seen); }
double OnlineLearner::time() const noexcept { return impl_->motion.time(1); }
const VectorXd& OnlineLearner::variables() const noexcept { return impl_->x; }
const VectorXd& OnlineLearner::values() const noexcept { return impl_->values; }

LearnedNet learn_online(const Experiment& experiment, const std::shared_ptr<const PluginHost>& plugins,
                        const std::vector<Learnable>& with_guesses, const OnlineOptions& options,
                        const std::function<bool(const LearnProgress&)>& on_step) {
  const std::vector<Learnable> learnables = without_guesses(with_guesses);
  if (!plugins) throw Error(ErrorKind::input, "learning: there is no plugin host");
  LearnOptions of_judge;
  of_judge.memory = options.memory;
  learning::Judge judge({experiment}, plugins, learnables, of_judge);
  learning::Fit fit({experiment}, plugins, learnables, 0.0, 0, options.memory);  // checks, and judges at the end
  const learning::Variables& variables = fit.variables();
  OnlineLearner learner(experiment.network, plugins, experiment.options, learnables, options);
  LearnedNet result;
  result.method = "online";
  result.reason = "The motion was gone through once.";
  const double last = experiment.observations.times().back();
  constexpr double rounding = 1e-6;  // of a step
  const double slack = rounding * experiment.options.time_step;
  for (int step = 1; learner.time() < last - slack; ++step) {
    const double from = learner.time(), until = from + experiment.options.time_step + slack;
    const Observations seen = learning::part_of(experiment.observations, step == 1 ? from : from + slack, until);
    double cost = 0.0;
    try {
      cost = learner.step(seen);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::plugin || result.history.empty()) throw;
      result.failure = error.what();
      result.reason = fmt::format("An error ended it at {:g} s; the values are those until then.", from);
      break;
    }
    const double count = static_cast<double>(seen.value_count());
    if (!(count > 0.0)) continue;
    LearnProgress now{step, learner.time() / last, cost, std::sqrt(2.0 * cost / count), {}};
    now.done = now.share;
    result.history.push_back(now);
    now.work = static_cast<double>(step) * static_cast<double>(1 + variables.count());
    now.values = learner.values();
    if (!on_step || on_step(now)) continue;
    result.stopped = true;
    result.reason = "It was stopped; the values are those until then.";
    break;
  }
  result.values = learner.values();
  result.observed = fit.observed();
  result.variables = static_cast<std::size_t>(variables.count());
  result.start_cost = 0.5 * fit.observed_residuals(variables.start()).squaredNorm();
  const VectorXd residuals = fit.observed_residuals(learner.variables());
  result.cost = 0.5 * residuals.squaredNorm();
  result.rms = learning::rms_of(residuals, fit.observed());
  if (result.cost > result.start_cost)
    result.notes.emplace_back("The values at the end are worse than those at the start: learn more slowly (rate).");
  if (!residuals.allFinite()) result.notes.push_back("A motion with the values at the end fails: " + fit.why_failed());
  fit.note_events(result.notes);
  result.parameters = learning::list_parameters(learnables);
  if (residuals.allFinite())
    learning::judge_fit({experiment}, residuals,
                        "the whole motion (--method trajectory) finds more, and several starts of it (--starts 8)",
                        result);
  judge.judge(learner.variables(), result);
  learning::describe(result, variables, learner.variables(), nullptr, {});
  learning::add_notes(result);
  return result;
}

}  // namespace springnet
