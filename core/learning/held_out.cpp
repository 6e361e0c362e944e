#include "learning/held_out.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/check_held_out.hpp"
#include "learning/fit.hpp"
#include "learning/result.hpp"

namespace springnet::learning {

std::vector<Experiment> learned_from(const std::vector<Experiment>& experiments) {
  std::vector<Experiment> result;
  for (const Experiment& each : experiments)
    if (each.observations.value_count() > 0 || each.held_out.value_count() == 0) result.push_back(each);
  if (result.empty() && !experiments.empty())
    throw Error(ErrorKind::input, "learning: all observations are held out; leave some to learn from");
  return result;
}

Judge::Judge(const std::vector<Experiment>& experiments, const std::shared_ptr<const PluginHost>& plugins,
             const std::vector<Learnable>& learnables, const LearnOptions& options)
    : plugins_(plugins), learnables_(learnables), threads_(options.threads), memory_(options.memory) {
  for (const Experiment& each : experiments) {
    if (each.held_out.value_count() == 0) continue;
    if (!each.network) throw Error(ErrorKind::input, "learning: an experiment has no network");
    check_held_out(each.observations, each.held_out, each.network->nodes().size());
    experiments_.push_back({each.network, each.options, each.held_out, {}, each.name});
  }
  if (experiments_.empty()) return;
  Fit fit(experiments_, plugins_, learnables_, 0.0, threads_, memory_);  // what cannot be judged is refused at once
  start_rms_ = rms_of(fit.observed_residuals(fit.variables().start()), fit.observed());
}

void Judge::judge(const Eigen::VectorXd& x, LearnedNet& learned) {
  if (experiments_.empty()) return;
  Fit fit(experiments_, plugins_, learnables_, 0.0, threads_, memory_);
  learned.held_out.observed = fit.observed();
  learned.held_out.start_rms = start_rms_;
  learned.held_out.rms = rms_of(fit.observed_residuals(x), fit.observed());
  if (!std::isfinite(learned.held_out.rms))
    learned.notes.push_back("The motion of what was held out fails with the learned values: " + fit.why_failed());
}

void Judge::judge_half_step(const Eigen::VectorXd& x, LearnedNet& learned) {
  if (experiments_.empty() || !std::isfinite(learned.held_out.rms)) return;
  try {
    Fit half(with_half_the_step(experiments_), plugins_, learnables_, 0.0, threads_, memory_);
    const Variables& variables = half.variables();
    learned.held_out.half_step_rms =
        rms_of(half.observed_residuals(x.cwiseMax(variables.lower()).cwiseMin(variables.upper())), half.observed());
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::plugin) throw;  // else it stays unknown, as that of the values is
  }
}

std::vector<Experiment> with_half_the_step(std::vector<Experiment> experiments) {
  for (Experiment& each : experiments) each.options.time_step *= 0.5;
  return experiments;
}

}  // namespace springnet::learning
