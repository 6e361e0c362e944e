#include "learning/fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/experiment_threads.hpp"
#include "learning/in_threads.hpp"
#include "learning/lanczos.hpp"
#include "learning/notes.hpp"
#include "learning/same_object.hpp"

namespace springnet::learning {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The whole number of steps that reaches the last observation, s.
double duration_of(const Experiment& experiment) {
  const std::vector<double> times = experiment.observations.times();
  if (times.empty()) {
    check_observations(experiment.observations, experiment.network->nodes().size(), 0.0, 0.0);  // names the file
    throw Error(ErrorKind::input, "learning: there are no observations");
  }
  const double step = experiment.options.time_step;
  constexpr double rounding = 1e-6;  // of a step
  return step * std::max(1.0, std::ceil(times.back() / step - rounding));
}

std::vector<double> times_of(const MotionDerivatives& motion) {
  std::vector<double> times;
  for (std::size_t k = 0; k <= motion.step_count(); ++k) times.push_back(motion.time(k));
  return times;
}

// Those whose times the derivatives leave as they are, at the ends of steps. Others were located within a step.
std::vector<Event> not_located(const MotionDerivatives& motion) {
  constexpr double rounding = 1e-6;  // of a step
  const double start = motion.time(0), step = motion.time(1) - start;
  std::vector<Event> result = motion.events();
  std::erase_if(result, [&](const Event& each) {
    const double steps = (each.time - start) / step;
    return std::abs(steps - std::round(steps)) > rounding;
  });
  return result;
}

}  // namespace

template <class Work>
void Fit::for_each_run(const Work& work) const {
  in_threads(runs_.size(), at_a_time_, work);
}

Fit::Fit(const std::vector<Experiment>& experiments, const std::shared_ptr<const PluginHost>& plugins,
         const std::vector<Learnable>& learnables, double guess_weight, unsigned threads, std::size_t memory) {
  if (experiments.empty()) throw Error(ErrorKind::input, "learning: there is no experiment");
  set_guess_weight(guess_weight);
  check_same_object(experiments);
  check_same_gravity(experiments, learnables);
  check_same_friction(experiments, learnables);
  at_a_time_ = experiments_at_a_time(experiments, *plugins, threads);
  std::vector<double> durations;
  for (const Experiment& each : experiments) {
    durations.push_back(duration_of(each));
    check_observations(each.observations, each.network->nodes().size(), 0.0, durations.back());
  }
  std::vector<std::unique_ptr<MotionDerivatives>> motions(experiments.size());
  std::vector<std::unique_ptr<ObservedNet>> nets(experiments.size());
  const auto make = [&](std::size_t k) {
    const Experiment& each = experiments[k];
    motions[k] = std::make_unique<MotionDerivatives>(
        each.network, plugins, with_share_of_threads(each, threads, at_a_time_), durations[k], values_of(learnables));
    motions[k]->set_memory(memory / experiments.size());
    nets[k] = std::make_unique<ObservedNet>(each.network, plugins, each.options, values_of(learnables));
  };
  make(0);
  variables_ =
      std::make_unique<Variables>(*experiments[0].network, *plugins, learnables, motions[0]->values_of_network());
  const VectorXd values = variables_->values(variables_->start());
  in_threads(experiments.size(), at_a_time_, [&](std::size_t k) {
    if (k > 0) make(k);
    motions[k]->run(values);
  });
  for (std::size_t k = 0; k < experiments.size(); ++k) {
    ObservedMotion observed(experiments[k].observations, times_of(*motions[k]), *nets[k]);
    const Eigen::Index first = rows_;
    rows_ += observed.count();
    observed_ += experiments[k].observations.value_count();
    std::vector<Event> events = motions[k]->events();
    extent_ = std::hypot(extent_, observed.extent(*experiments[k].network));
    runs_.push_back({std::move(motions[k]), std::move(nets[k]), std::move(observed), first,
                     static_cast<Eigen::Index>(experiments[k].network->nodes().size()), std::move(events)});
  }
}

// What is left of steps moves each node somewhere; beside that, what is to be seen is not so small a part of the
// motion.
void Fit::find_unseen() {
  constexpr double most = 1e-7;  // of the motion
  VectorXd left = VectorXd::Zero(rows_);
  for (const Run& each : runs_) {
    const auto count = static_cast<Eigen::Index>(each.motion->value_count());
    const MatrixXd values = MatrixXd::Zero(count, 1);
    const VectorXd anywhere = arbitrary_vector(3 * each.nodes, 1).cwiseSign();
    for (std::size_t k = 0; k <= each.motion->step_count(); ++k) {
      const MotionDerivatives::Settled settled = each.motion->settled_to(k);
      each.observed.add_tangent(*each.motion, k, {values, settled.position * anywhere, settled.velocity * anywhere},
                                left.segment(each.first, each.observed.count()));
    }
  }
  unseen_ = std::min(left.norm(), most * extent_);
}

void Fit::set_guess_weight(double weight) {
  if (!(weight >= 0.0) || !std::isfinite(weight))
    throw Error(ErrorKind::input, fmt::format("learning: the weight of the guess is {}, must be 0 or more", weight));
  root_guess_weight_ = std::sqrt(weight);
}

void Fit::set_accuracy(double relative) {
  for (const Run& each : runs_) each.motion->set_accuracy(relative);
}

void Fit::set_smoothness(double deviation) {
  if (!(deviation > 0.0))
    throw Error(ErrorKind::input,
                fmt::format("learning: the deviation of changes of accelerations is {} m/s^2, must be "
                            "above 0",
                            deviation));
  smooth_rows_ = 0;
  for (Run& each : runs_) {
    each.smoothness.reset();
    if (!std::isfinite(deviation)) continue;
    const MotionDerivatives& motion = *each.motion;
    each.smoothness.emplace(deviation, motion.step_count(), motion.time(1) - motion.time(0),
                            static_cast<std::size_t>(each.nodes));
    each.first_smooth = smooth_rows_;
    smooth_rows_ += each.smoothness->count();
  }
}

double Fit::smooth_cost(const VectorXd& x) {
  if (smooth_rows_ == 0) return 0.0;
  if (smooth_at_.size() == x.size() && smooth_at_ == x) return smooth_cost_;
  const VectorXd all = residuals(x);
  return 0.5 * all.segment(rows_, smooth_rows_).squaredNorm();
}

double Fit::guess_cost(const VectorXd& x) const {
  const double weight = root_weight();
  return 0.5 * weight * weight * (x - variables_->start()).cwiseQuotient(variables_->scale()).squaredNorm();
}

template <class Work>
bool Fit::tell(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::plugin) throw;
    failure_ = error.what();
    return false;
  }
  return true;
}

double Fit::steps() const {
  std::size_t sum = 0;
  for (const Run& each : runs_) sum += each.motion->step_count();
  return static_cast<double>(sum);
}

bool Fit::run(const VectorXd& x) {
  if (at_.size() == x.size() && at_ == x) return true;
  if (!move(variables_->values(x))) return false;
  at_ = x;
  return true;
}

bool Fit::move(const VectorXd& values) {
  at_.resize(0);
  count(1.0);
  return tell([&] { for_each_run([&](std::size_t k) { runs_[k].motion->run(values); }); });
}

void Fit::add_residuals(const VectorXd& values, VectorXd& out) {
  for_each_run([&](std::size_t k) {
    Run& each = runs_[k];
    each.observed.residuals(*each.motion, values, out.segment(each.first, each.observed.count()));
  });
}

double Fit::cost_of(const VectorXd& values) {
  if (!move(values)) return std::numeric_limits<double>::quiet_NaN();
  VectorXd residuals = VectorXd::Zero(rows_);
  add_residuals(values, residuals);
  return 0.5 * residuals.squaredNorm();
}

VectorXd Fit::residuals(const VectorXd& x) {
  VectorXd observed = VectorXd::Zero(rows_);
  const bool moves = run(x) && tell([&] { add_residuals(variables_->values(x), observed); });
  if (!moves) observed.setConstant(std::numeric_limits<double>::quiet_NaN());
  if (moves && !is_unseen_known_) find_unseen();
  is_unseen_known_ = is_unseen_known_ || moves;
  const Eigen::Index guess_rows = root_weight() > 0.0 ? x.size() : 0;
  VectorXd result = VectorXd::Zero(rows_ + smooth_rows_ + guess_rows);
  result.head(rows_) = observed;
  if (!moves) result.segment(rows_, smooth_rows_).setConstant(std::numeric_limits<double>::quiet_NaN());
  if (moves && smooth_rows_ > 0) {
    for_each_run([&](std::size_t k) {
      const Run& each = runs_[k];
      each.smoothness->residuals(*each.motion, result.segment(rows_ + each.first_smooth, each.smoothness->count()));
    });
    smooth_at_ = x;
    smooth_cost_ = 0.5 * result.segment(rows_, smooth_rows_).squaredNorm();
  }
  if (guess_rows > 0 && !moves) result.tail(guess_rows).setConstant(observed[0]);
  if (guess_rows > 0 && moves)
    result.tail(guess_rows) = root_weight() * (x - variables_->start()).cwiseQuotient(variables_->scale());
  return result;
}

void Fit::note_events(std::vector<std::string>& notes) const {
  if (at_.size() == 0) return;  // a motion has failed
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const std::string text = note_of_events(not_located(*runs_[i].motion), runs_[i].events_at_start);
    if (text.empty()) continue;
    notes.push_back((runs_.size() > 1 ? fmt::format("Experiment {}: ", i + 1) : "") + text);
  }
}

void Fit::linearise(const VectorXd& x) {
  const VectorXd known = residuals(x);  // which keeps the directions of distances
  if (!known.allFinite()) throw Error(ErrorKind::simulation, "learning: " + failure_);
}

MatrixXd Fit::products(const MatrixXd& changes, bool all_rows) {
  const Eigen::Index guess_rows = all_rows && root_weight() > 0.0 ? changes.rows() : 0;
  MatrixXd result = MatrixXd::Zero(rows_ + (all_rows ? smooth_rows_ : 0) + guess_rows, changes.cols());
  const MatrixXd values = variables_->times(at_, changes);
  count(static_cast<double>(changes.cols()));
  for_each_run([&](std::size_t k) {
    const Run& each = runs_[k];
    each.motion->tangent(values, [&](std::size_t state, const MatrixXd& positions, const MatrixXd& velocities) {
      each.observed.add_tangent(*each.motion, state, {values, positions, velocities},
                                result.middleRows(each.first, each.observed.count()));
      if (all_rows && each.smoothness)
        each.smoothness->add_tangent(state, velocities,
                                     result.middleRows(rows_ + each.first_smooth, each.smoothness->count()));
    });
  });
  if (guess_rows > 0)
    result.bottomRows(guess_rows) = root_weight() * variables_->scale().cwiseInverse().asDiagonal() * changes;
  return result;
}

VectorXd Fit::transposed_times(const VectorXd& weights) {
  std::vector<VectorXd> gradients(runs_.size());
  count(1.0);
  for_each_run([&](std::size_t k) {
    const Run& each = runs_[k];
    VectorXd directly = VectorXd::Zero(static_cast<Eigen::Index>(each.motion->value_count()));
    const VectorXd by_states = each.motion->adjoint([&](std::size_t state, MotionDerivatives::StateChange& add) {
      each.observed.add_adjoint(*each.motion, state, weights.segment(each.first, each.observed.count()), add, directly);
      if (each.smoothness)
        each.smoothness->add_adjoint(state, weights.segment(rows_ + each.first_smooth, each.smoothness->count()), add);
    });
    gradients[k] = by_states + directly;
  });
  VectorXd gradient = gradients.front();  // summed in the order of the experiments, whichever was done first
  for (std::size_t k = 1; k < gradients.size(); ++k) gradient += gradients[k];
  VectorXd result = variables_->transposed_times(at_, gradient);
  if (const Eigen::Index before = rows_ + smooth_rows_; weights.size() > before)
    result += root_weight() * weights.tail(weights.size() - before).cwiseQuotient(variables_->scale());
  return result;
}

}  // namespace springnet::learning
