#include "newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <springnet/sdk/math.hpp>

#include "columns.hpp"

namespace springnet::recurrent {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
// A share of the direction is accepted if the slope at its end has not reversed beyond `overshoot` of the slope at the
// start and the residual grew by at most `max_growth`, or if the residual fell to `good_decrease`.
constexpr double overshoot = 0.5, max_growth = 3.0, good_decrease = 0.5;
constexpr int max_shares = 5, max_shifts = 12;
// Each restoration must reduce the residual to `restoration_factor`, or the step is shortened. It moves other
// directions by about 1 / restoration_weight of the step. `restoration_accuracy` is that of iterative solutions.
// (Measured on enclosed volumes of 1e3 to 1e14 N/m^5.)
constexpr double restoration_factor = 0.6, restoration_weight = 3.0, restoration_accuracy = 0.1;
constexpr int max_restorations = 8;
constexpr double first_shift = 1.0, shift_growth = 10.0, min_shift = 0.05;
// Renewing them costs about as much as these iterations of a linear solve; a sweep costs those of its solve and some
// more. Derivatives at hand reduce the residual by this at best, as the first solves are no more accurate.
constexpr double cost_of_renewal = 10.0, cost_of_sweep = 3.0, best_rate = 0.015;
// A step from a guess that has not settled after this many sweeps starts again from its start, unless the last half of
// them, and of each as many later, has reduced the residual to this share: a guess may lead contacts into a cycle.
constexpr std::uint64_t patience_with_guess = 12;
constexpr double settling_share = 0.1;
// Slow sweeps in turn, not counting those right after contacts changed, before systems are exact.
constexpr int sweeps_to_blame = 3;
// Steps in which systems are exact after an approximate one has converged slowly; and in which they are not, after an
// exact one has, too.
constexpr int max_exact_steps = 16, max_approximate_steps = 64;
// Accuracy of iterative solutions: that of the first sweep; then by the last reduction of the residual, as Eisenstat
// and Walker advise (1996, choice 2 with exponent 2), but no finer than to settle with some margin.
constexpr double first_accuracy = 0.01, loosest_accuracy = 0.1, tightest_accuracy = 1e-3, accuracy_factor = 0.9;
constexpr double settling_margin = 0.25;
constexpr double accuracy_of_first_step = 1e-3;  // without a guess, from where the step starts
// Steps and corrections this small, relative to the positions, are rounding.
constexpr double negligible = 1e-14;

// Gap between where U leads and P, as a velocity: (p* + w U - P) / w, m/s, with `start` p* (m) and weight w (s).
double gap_of(double start, double w, double velocity, double position) noexcept {
  const double gap = (start - position) / w + velocity;
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * (std::abs(start) + std::abs(position)) / w;
  return std::abs(gap) <= rounding ? 0.0 : gap;
}

}  // namespace

void Newton::attach(const springnet_network& network) {
  system_.attach(network);
  const std::size_t n = network.node_count;
  for (auto* values : {&at_outputs_.free, &at_outputs_.residual, &at_candidate_.free, &at_candidate_.residual,
                       &right_side_, &direction_, &gap_, &work_values_, &uncorrected_, &correction_})
    values->assign(3 * n, 0.0);
  pinned_.assign(n, 0);
  status_.assign(n, SPRINGNET_FREE);
  linearised_ = false;
  in_contact_.clear();
  for (std::size_t k = 0; k < n; ++k) {
    if (network.cluster[k] != no_node && network.cluster[k] >= in_contact_.size())
      in_contact_.resize(network.cluster[k] + std::size_t{1});
  }
  pushed_.assign(network.body_contact_count > 0 ? n : 0, 0);
  if (network.surface_count == 0 && network.body_contact_count == 0) return;
  contacts_.clear();
  contacts_.reserve(n);
  inertia_.assign(9 * n, 0.0);
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < 9; i += 4) inertia_[9 * k + i] = network.mass[k];
  contact_acceleration_.resize(n);
  by_velocity_.resize(9 * n);
  by_position_.resize(9 * n);
}

void Newton::forget() noexcept {
  extrapolation_.forget();
  linearised_ = fresh_ = at_rejected_ = first_ = guessed_ = is_solved_ = false;
  shift_ = 0.0;
  rate_ = kept_rate_ = last_accuracy_ = 1.0;
  exact_steps_ = approximate_steps_ = age_ = 0;
  is_exact_ = false;
  contact_changes_ = 0;
  slow_sweeps_ = 0;
}

void Newton::assess(const Step& step, const springnet_state& state, Assessment& result) {
  const std::size_t n = step.network.node_count;
  const bool constrained = step.constrained();
  const double w = step.weight();
  const ThreeConst a = axes(constrained ? work_.free_acceleration() : work_.acceleration());
  // On nodes with only rigid connections, the connection forces act along their present directions.
  const ThreeConst constrained_a = axes(work_.acceleration());
  const ThreeConst c = axes(work_.constraint_force()), v = axes(step.free_velocity);
  const Three u = axes(state.velocity);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = axis * n + k;
      const double acceleration = joined_without_contact(step, k) ? constrained_a[axis][k] : a[axis][k];
      result.free[i] = u[axis][k] - v[axis][k] - w * acceleration;
      const bool has_constraint_force = constrained && !joined_without_contact(step, k);
      const double r = has_constraint_force ? result.free[i] - w / step.network.mass[k] * c[axis][k] : result.free[i];
      result.residual[i] = pinned_[k] != 0 ? 0.0 : r;
    }
  }
  // Constraint forces belong to the previous outputs; project out their error, which is not a residual.
  if (linearised_) system_.project(result.residual);
  double square = 0.0, slope = 0.0;
  for (std::size_t i = 0; i < 3 * n; ++i) {
    const double impulse = step.network.mass[i % n] * result.residual[i];
    square += impulse * result.residual[i];
    slope += impulse * direction_[i];
  }
  result.norm = std::isfinite(square) ? std::sqrt(square) : infinite;
  result.slope = slope;
}

void Newton::linearise(const Step& step) {
  is_exact_ = exact_steps_ > 0;
  system_.prepare(step.evaluation_at_end(*step.outputs), step.weight(), shift_, is_exact_);
  linearised_ = fresh_ = true;
  at_rejected_ = false;
  age_ = 0;
}

void Newton::set_up(const Step& step) {
  const std::size_t n = step.network.node_count;
  const springnet_state& outputs = *step.outputs;
  const double w = step.weight();
  // Nodes whose P is not p* + w U are moved there: w^2 da/dp (p* + w U - P) / w.
  double greatest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double *start = axes(step.free_position)[axis], *u = axes(outputs.velocity)[axis];
    const double* p = axes(outputs.position)[axis];
    for (std::size_t k = 0; k < n; ++k) {
      const bool free = pinned_[k] == 0 && !is_partly_constrained(step, k);
      const double gap = free ? gap_of(start[k], w, u[k], p[k]) : 0.0;
      gap_[axis * n + k] = gap;
      greatest = std::max(greatest, std::abs(gap));
    }
  }
  const bool fast = shift_ == 0.0 && rate_ < fast_convergence && keeping_pays(step);
  const bool keeps = linearised_ && !at_rejected_ && (fresh_ || fast) && system_.has(w, shift_);
  if (!keeps) linearise(step);
  std::fill(right_side_.begin(), right_side_.end(), 0.0);
  if (greatest > 0.0) {
    work_.host.linearise(step.evaluation_at_end(outputs));
    for (std::size_t i = 0; i < 3 * n; ++i) work_values_[i] = w * w * gap_[i];
    std::fill(direction_.begin(), direction_.end(), 0.0);
    work_.host.jacobian_times(work_values_.data(), direction_.data(), right_side_.data());
  }
  for (std::size_t i = 0; i < 3 * n; ++i)
    right_side_[i] = pinned_[i % n] != 0 ? 0.0 : right_side_[i] - at_outputs_.residual[i];
  system_.project(right_side_);
}

// Whether the sweeps that kept derivatives need until the step has settled cost less than renewing them.
bool Newton::keeping_pays(const Step& step) const {
  const double force = greatest_force(step, at_outputs_.residual);
  if (!(force > step.tolerance)) return true;
  const auto sweeps = [&](double rate) { return std::ceil(sdk::log(step.tolerance / force) / sdk::log(rate)); };
  const double cost = static_cast<double>(system_.iterations()) + cost_of_sweep;
  return sweeps(std::max(kept_rate_, best_rate)) * cost <= sweeps(best_rate) * cost + cost_of_renewal;
}

// Of the linear system of this sweep.
double Newton::accuracy(const Step& step) const {
  const double wanted = first_ ? first_accuracy : std::min(first_accuracy, accuracy_factor * rate_ * rate_);
  const double force = greatest_force(step, at_outputs_.residual);
  const double enough = force > 0.0 ? settling_margin * step.tolerance / force : loosest_accuracy;
  return std::clamp(std::max(wanted, enough), tightest_accuracy, loosest_accuracy);
}

void Newton::find_direction(const Step& step, double accuracy) {
  if (!system_.has(step.weight(), shift_)) linearise(step);
  is_solved_ = system_.solve(right_side_, accuracy, direction_);
  last_accuracy_ = accuracy;
  at_outputs_.slope = is_solved_ ? slope_along(step, direction_) : 0.0;
}

double Newton::slope_along(const Step& step, const std::vector<double>& direction) const {
  const std::size_t n = step.network.node_count;
  double slope = 0.0;
  for (std::size_t i = 0; i < 3 * n; ++i) slope -= step.network.mass[i % n] * right_side_[i] * direction[i];
  return slope;
}

void Newton::evaluate_candidate(const Step& step, double share, const springnet_state& candidate) {
  const std::size_t n = step.network.node_count;
  const springnet_state& outputs = *step.outputs;
  const double w = step.weight();
  const Three u = axes(outputs.velocity), next_u = axes(candidate.velocity);
  const Three p = axes(outputs.position), next_p = axes(candidate.position);
  const ThreeConst start = axes(step.free_position);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = axis * n + k;
      const double change = pinned_[k] != 0 ? 0.0 : share * direction_[i];
      next_u[axis][k] = u[axis][k] + change;
      // Free nodes exactly, so that rounding does not accumulate.
      if (share == 1.0 && pinned_[k] == 0 && !is_partly_constrained(step, k))
        next_p[axis][k] = start[axis][k] + w * next_u[axis][k];
      else
        next_p[axis][k] = p[axis][k] + w * (change + (pinned_[k] != 0 ? 0.0 : share * gap_[i]));
    }
  }
  at_candidate_.norm = at_candidate_.slope = infinite;
  try {
    work_.evaluate(step, candidate);
    work_.free_accelerations(step);
    refresh_friction(step, candidate, step.outputs);
    assess(step, candidate, at_candidate_);
  } catch (const sdk::Failure& failure) {
    if (!failure.recoverable()) throw;
  }
}

double Newton::greatest_force(const Step& step, const std::vector<double>& residual) {
  const std::size_t n = step.network.node_count;
  double greatest = 0.0;
  for (std::size_t i = 0; i < 3 * n; ++i)
    greatest = std::max(greatest, std::abs(residual[i]) * step.network.mass[i % n] / step.time_constant);
  return greatest;
}

bool Newton::is_good(const Step& step, double slope) const {
  if (!std::isfinite(at_candidate_.norm)) return false;
  const bool falls = at_candidate_.slope <= -overshoot * slope && at_candidate_.norm <= max_growth * at_outputs_.norm;
  if (falls || at_candidate_.norm <= good_decrease * at_outputs_.norm) return true;
  if (greatest_force(step, at_candidate_.residual) <= step.rounding) return true;
  // Accept steps of the size of rounding.
  const std::size_t n = step.network.node_count;
  double greatest = 0.0, size = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* p = axes(step.outputs->position)[axis];
    for (std::size_t k = 0; k < n; ++k) {
      greatest = std::max(greatest, std::abs(step.weight() * direction_[axis * n + k]));
      size = std::max(size, std::abs(p[k]));
    }
  }
  return greatest <= negligible * size;
}

bool Newton::restore(const Step& step, const springnet_state& candidate) {
  const std::size_t n = step.network.node_count;
  uncorrected_ = direction_;
  const double uncorrected_slope = at_candidate_.slope;
  for (int tries = 0; tries < max_restorations && std::isfinite(at_candidate_.norm) && work_.host.time_left() > 0.0;
       ++tries) {
    double square = 0.0;
    for (std::size_t i = 0; i < 3 * n; ++i) square += step.network.mass[i % n] * direction_[i] * direction_[i];
    const double before = at_candidate_.norm, shift = restoration_weight * before / std::sqrt(square);
    if (!std::isfinite(shift)) break;
    at_rejected_ = true;
    try {
      system_.prepare(step.evaluation_at_end(candidate), step.weight(), shift, true);
    } catch (const sdk::Failure& failure) {
      if (!failure.recoverable()) throw;
      break;  // no derivatives there: shorten the step
    }
    for (std::size_t i = 0; i < 3 * n; ++i) work_values_[i] = -at_candidate_.residual[i];
    system_.project(work_values_);
    if (!system_.solve(work_values_, restoration_accuracy, correction_)) break;
    for (std::size_t i = 0; i < 3 * n; ++i) direction_[i] += correction_[i];
    evaluate_candidate(step, 1.0, candidate);
    if (!(at_candidate_.norm <= restoration_factor * before)) break;
    // The first sweep has no slope to test.
    if (first_ ? at_candidate_.norm <= at_outputs_.norm : is_good(step, slope_along(step, direction_))) return true;
  }
  direction_ = uncorrected_;
  at_candidate_.norm = infinite;
  at_candidate_.slope = uncorrected_slope;
  if (at_rejected_ && !first_) linearise(step);  // the first sweep linearises anew
  return false;
}

bool Newton::try_whole_step(const Step& step, const springnet_state& candidate) {
  find_direction(step, accuracy(step));
  if (!is_solved_ || system_.truncated() || at_outputs_.slope > 0.0) return false;
  const double slope = at_outputs_.slope;
  evaluate_candidate(step, 1.0, candidate);
  if (!fresh_) {
    return at_candidate_.norm <= good_decrease * at_outputs_.norm ||
           (std::isfinite(at_candidate_.norm) && greatest_force(step, at_candidate_.residual) <= step.tolerance);
  }
  return is_good(step, slope) || (at_candidate_.norm > max_growth * at_outputs_.norm && restore(step, candidate));
}

void Newton::relax_shift() noexcept { shift_ = shift_ / shift_growth < min_shift ? 0.0 : shift_ / shift_growth; }

void Newton::search(Step& step, const springnet_state& candidate) {
  const double wanted = accuracy(step);
  // At a deadline the outputs stay as they are.
  const auto is_late = [&] {
    if (work_.host.time_left() > 0.0) return false;
    std::fill(direction_.begin(), direction_.end(), 0.0);
    evaluate_candidate(step, 0.0, candidate);
    return true;
  };
  for (int shifts = 0; shifts < max_shifts; ++shifts) {
    find_direction(step, wanted);
    if (is_solved_ && at_outputs_.slope <= 0.0) {
      const double slope = at_outputs_.slope;
      double share = 1.0;
      for (int tries = 0; tries < max_shares; ++tries) {
        evaluate_candidate(step, share, candidate);
        if (is_good(step, slope)) {
          if (tries == 0) relax_shift();
          return;
        }
        if (is_late()) return;
        if (tries == 0 && at_candidate_.norm > max_growth * at_outputs_.norm && restore(step, candidate)) {
          relax_shift();
          return;
        }
        // Zero of the linear interpolation of the slopes, away from both ends.
        const double zero = std::isfinite(at_candidate_.slope) ? slope / (slope - at_candidate_.slope) : 0.0;
        share *= std::clamp(zero, 0.1, 0.6);
      }
    }
    if (is_late()) return;
    shift_ = std::max(first_shift, shift_growth * shift_);
  }
  if (!std::isfinite(at_candidate_.norm))
    throw sdk::Failure("no step of Newton's method from here has finite forces", SPRINGNET_RECOVERABLE);
}

void Newton::sweep(Step& step) {
  if (guessed_ && !is_about_to_settle(step)) start_again(step);
  std::uint64_t decisions = decisions_;
  double before_contact = 0.0;  // residual of the outputs by which contacts are decided, N
  const double norm_before = at_outputs_.norm;
  for (int tries = 1;; ++tries) {
    springnet_state& start = *step.outputs;
    springnet_state& candidate = work_.state_beside(&start);
    bool advanced = false;
    try {
      advanced = advance(step, candidate);
    } catch (const sdk::Failure& failure) {
      if (!guessed_ || !first_ || !failure.recoverable()) throw;  // else: no finite derivatives at the guess
    }
    if (!advanced) {
      start_again(step);
      decisions = decisions_;
      continue;
    }
    if (!step.may_be_constrained()) break;
    if (step.constrained()) before_contact = greatest_force(step, at_outputs_.residual);
    try {
      settle(step, &start);
      break;
    } catch (const sdk::Failure& failure) {
      if (!failure.recoverable() || tries >= max_shifts) throw;
    }
    // The constraints cannot be satisfied that far away: shorten the step.
    std::swap(at_outputs_, at_candidate_);
    step.outputs = &start;
    linearised_ = fresh_ = false;
    shift_ = std::max(first_shift, shift_growth * shift_);
  }
  // Friction may have turned with the slips. That of rigid clusters follows the sweeps, which renewing does not help.
  const bool switched = last_switch_ == step.sweeps;
  if (!switched && norm_before > 0.0 && step.network.rigid_count == 0)
    rate_ = std::max(rate_, at_outputs_.norm / norm_before);
  step.residual = residual(step);
  step.norm = at_outputs_.norm;
  step.rate = rate_;
  // Contacts just decided may change again; forces of rigid connections belong to the sweep before.
  step.residual_decides = decisions_ == decisions && before_contact <= step.tolerance && step.network.rigid_count == 0;
  ++step.sweeps;
  step.evaluated = true;
  step.finite = std::isfinite(at_outputs_.norm) && std::isfinite(step.residual);
  compare_forces(step);
}

bool Newton::is_about_to_settle(const Step& step) {
  if (step.sweeps % (patience_with_guess / 2) != 0) return true;
  const double before = norm_at_half_;
  norm_at_half_ = at_outputs_.norm;
  return step.sweeps < patience_with_guess || norm_at_half_ <= settling_share * before;
}

bool Newton::advance(Step& step, springnet_state& candidate) {
  step.is_provisional = false;
  set_up(step);
  bool done = false;
  if (!first_ || guessed_) {
    const bool kept = !fresh_;
    done = (kept || guessed_) && try_whole_step(step, candidate);
    if (!done && kept) {
      linearise(step);
      set_up(step);
      done = guessed_ && first_ && try_whole_step(step, candidate);
    }
    if (!done && guessed_ && first_) return false;
    if (!done) search(step, candidate);
  } else {
    // The step of the system linearised at the start, which needs no P = p* + w U there.
    find_direction(step, accuracy_of_first_step);
    if (is_solved_) evaluate_candidate(step, 1.0, candidate);
    const bool is_off = at_candidate_.norm > max_growth * at_outputs_.norm;
    const bool is_near = is_solved_ && (at_candidate_.norm <= at_outputs_.norm || (is_off && restore(step, candidate)));
    if (!is_near) start_at_rest(step, candidate);
    step.is_provisional = !is_near;
  }
  first_ = false;
  rate_ = at_outputs_.norm > 0.0 ? at_candidate_.norm / at_outputs_.norm : 0.0;
  // An inaccurate solution tells nothing of the derivatives.
  if (last_accuracy_ <= first_accuracy) kept_rate_ = fresh_ ? rate_ : std::max(kept_rate_, rate_);
  // What the host left out of an approximate system may be to blame, but not where an exact one does no better.
  const bool is_slow = fresh_ && rate_ >= fast_convergence && last_accuracy_ <= first_accuracy;
  slow_sweeps_ = is_slow ? slow_sweeps_ + (switched_ ? 0 : 1) : 0;
  if (is_slow && (is_exact_ || slow_sweeps_ >= sweeps_to_blame)) {
    exact_steps_ = is_exact_ || approximate_steps_ > 0 ? 0 : max_exact_steps;
    if (is_exact_) approximate_steps_ = max_approximate_steps;
  }
  std::swap(at_outputs_, at_candidate_);
  step.outputs = &candidate;
  fresh_ = false;
  return true;
}

// As Workspace::residual(), plus the remainder of shortened steps.
double Newton::residual(const Step& step) const {
  const springnet_network& network = step.network;
  const std::size_t n = network.node_count;
  const double w = step.weight();
  const springnet_state& outputs = *step.outputs;
  const auto square = [](double x, double y, double z) { return x * x + y * y + z * z; };
  Greatest greatest;
  for (std::uint32_t k = 0; k < n; ++k) {
    if (pinned_[k] != 0) continue;
    const double* r = at_outputs_.residual.data() + k;
    double left = square(r[0], r[n], r[2 * n]);
    if (!is_partly_constrained(step, k)) {
      left = std::max(left, square(gap_of(step.free_position.x[k], w, outputs.velocity.x[k], outputs.position.x[k]),
                                   gap_of(step.free_position.y[k], w, outputs.velocity.y[k], outputs.position.y[k]),
                                   gap_of(step.free_position.z[k], w, outputs.velocity.z[k], outputs.position.z[k])));
    }
    const double scale = network.mass[k] / step.time_constant;
    greatest.offer(scale * scale * left, k, network.user_number);
  }
  return std::sqrt(greatest.square);
}

// Includes forces on pinned nodes, as in the other rules.
void Newton::compare_forces(Step& step) {
  ForceRecord& record = work_.record;
  record.begin_sweep();
  const Columns& a = step.constrained() ? work_.free_acceleration() : work_.acceleration();
  record.take_all(step.network, sdk::view(step.outputs->force), a.view(), pinned_);
  step.differences = record.differences(step.network);
}

}  // namespace springnet::recurrent
