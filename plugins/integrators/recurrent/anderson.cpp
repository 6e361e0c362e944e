#include "anderson.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "columns.hpp"

namespace springnet::recurrent {
namespace {

// The residual may grow by this over the smallest one: on a linear network by at most |G|, for a sweep.
constexpr double max_growth = 10.0;
constexpr double max_first_growth = 2.0;
constexpr std::size_t slopes_after_first = 4;
constexpr double near = 1e-3;       // to the solution: residual over the greatest one
constexpr double min_change = 0.1;  // of the outputs, over the residual
constexpr double less_relaxation = 0.25;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double milestone_share = 0.5;
constexpr int max_since_milestone = 15;  // sweeps
constexpr int patience = 20;             // sweeps without a smaller residual
constexpr int max_stalls = 2;            // then plain sweeps
constexpr double max_steepness = 4.0;
// A difference of which the newer ones leave less than this, squared and relative, is dropped.
constexpr double min_independent = 1e-12;

// What acts on a node besides springs and loads.
constexpr std::uint8_t pinned_node = 0, sliding_node = 1, joined_node = 2, free_node = 3;
std::uint8_t status_of(const springnet_network& network, std::uint32_t k) noexcept {
  const std::uint8_t status = network.status[k];
  if (network.fixed[k] != 0 || status == SPRINGNET_PRESCRIBED || status == SPRINGNET_STICKING) return pinned_node;
  if (status == SPRINGNET_SLIDING) return sliding_node;
  return network.cluster[k] != no_node ? joined_node : free_node;
}

// Sums in eight lanes: one order for every instruction set, and loops that vectorise.
constexpr std::size_t lanes = 8;
double sum(const std::array<double, lanes>& s) noexcept {
  return ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
}
double dot(const std::vector<double>& a, const std::vector<double>& b) noexcept {
  std::array<double, lanes> s{};
  const std::size_t whole = a.size() / lanes * lanes;
  for (std::size_t i = 0; i < whole; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) s[lane] += a[i + lane] * b[i + lane];
  for (std::size_t i = whole; i < a.size(); ++i) s[i - whole] += a[i] * b[i];
  return sum(s);
}

void copy_to(const springnet_vectors& from, std::vector<double>& to) {
  const std::size_t n = to.size() / 3;
  for (std::size_t axis = 0; axis < 3; ++axis) std::copy_n(axes(from)[axis], n, to.data() + axis * n);
}
void copy_from(const std::vector<double>& from, const springnet_vectors& to) {
  const std::size_t n = from.size() / 3;
  for (std::size_t axis = 0; axis < 3; ++axis) std::copy_n(from.data() + axis * n, n, axes(to)[axis]);
}

}  // namespace

void Anderson::attach(const springnet_network& network) {
  if (!is_on()) return;
  const std::size_t size = 3 * std::size_t{network.node_count};
  root_.assign(network.node_count, 0.0);
  common_ = root_;
  status_.assign(network.node_count, pinned_node);
  for (auto* values : {&input_, &last_input_, &residual_, &next_, &best_position_, &best_velocity_, &best_residual_})
    values->resize(size);
  x_.resize(depth_);
  f_.resize(depth_);
  for (std::size_t i = 0; i < depth_; ++i) {
    x_[i].resize(size);
    f_[i].resize(size);
  }
}

void Anderson::begin(Step& step, bool relaxes, bool changes_order) {
  if (!is_on()) return;
  changes_order_ = changes_order;
  milestone_ = infinity;
  since_milestone_ = 0;
  relaxes_ = relaxes;
  slopes_ = 0;
  greatest_norm_ = 0.0;
  count_ = 0;
  has_last_ = went_back_ = given_up_ = false;
  first_ = true;
  best_norm_ = start_norm_ = infinity;
  steepest_ = later_steepest_ = 0.0;
  damping_ = max_damping_ = 1.0;
  retreats_ = stalls_ = since_best_ = 0;
  step.keeps_order = true;
  step.relaxation = 1.0;
  step.waits = step.network.surface_count > 0;
  static_cast<void>(find_free(step));
  copy_to(step.newest().velocity, input_);
}

bool Anderson::find_free(const Step& step) {
  bool changed = false;
  common_ = root_;
  for (std::uint32_t k = 0; k < step.network.node_count; ++k) {
    const std::uint8_t status = status_of(step.network, k);
    if (status == status_[k]) continue;
    status_[k] = status;
    root_[k] = status == pinned_node ? 0.0 : std::sqrt(step.network.mass[k]);
    common_[k] = 0.0;
    changed = true;
  }
  return changed;
}

bool Anderson::record(Step& step) {
  if (!is_on() || given_up_) {
    went_back_ = contacts_changed_ = false;
    return step.finite;
  }
  went_back_ = contacts_changed_ = false;
  double norm = infinity;
  bool changed = false;
  if (step.finite) {
    changed = step.constrained() && find_free(step);
    const std::size_t n = root_.size();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double* u = axes(step.outputs->velocity)[axis];
      const double* input = input_.data() + axis * n;
      double* f = next_.data() + axis * n;
      for (std::size_t k = 0; k < n; ++k) f[k] = root_[k] * (u[k] - input[k]);
    }
    norm = std::sqrt(dot(next_, next_));
    if (std::isfinite(norm) && has_last_) add_difference(changed ? common_ : root_);
    if (changed) {
      contacts_changed_ = true;
      slopes_ = 0;
      count_ = 0;
      best_norm_ = start_norm_ = infinity;
      first_ = true;  // the sweep read outputs in which other nodes were in contact
    }
  }
  damping_ = std::min(max_damping_, 2.0 / (1.0 + std::max(1.0, steepest_)));
  const double least = std::min(best_norm_, start_norm_);
  const double limit = std::isfinite(best_norm_) ? max_growth : max_first_growth;
  const bool grew = !std::isfinite(norm) || norm > limit * least;
  const bool stalls = ++since_best_ > patience;
  // A wave may go on too far without diverging; then shorter moves settle sooner.
  const bool overshoots = relaxes_ && later_steepest_ > max_steepness;
  if (grew || stalls || overshoots) {
    stalls_ += stalls ? 1 : 0;
    given_up_ = ++retreats_ > max_retreats || stalls_ > max_stalls;
    if (given_up_ && !std::isfinite(best_norm_)) return step.finite;
    go_back(step);
    return true;
  }
  std::swap(residual_, next_);
  if (first_)
    start_norm_ = changed || norm == 0.0 ? infinity : norm;
  else if (norm < best_norm_)
    keep_best(*step.outputs, norm);
  has_last_ = true;
  if (step.relaxation == 1.0 && is_slow(norm)) {
    given_up_ = true;
    step.keeps_order = step.waits = false;
  }
  // Sweeps that go too far would touch surfaces that the solution does not touch.
  greatest_norm_ = std::max(greatest_norm_, norm);
  if (norm <= near * greatest_norm_) step.waits = false;
  return true;
}

// Whether sweeps that change their order, and settle without damping, may well need fewer without acceleration.
bool Anderson::is_slow(double norm) noexcept {
  if (norm > milestone_share * milestone_ && ++since_milestone_ < max_since_milestone) return false;
  const bool slow = norm > milestone_share * milestone_ && changes_order_ && damping_ == 1.0;
  milestone_ = norm;
  since_milestone_ = 0;
  return slow;
}

void Anderson::add_difference(const std::vector<double>& nodes) {
  const std::size_t n = nodes.size();
  const std::size_t at = (newest_ + 1) % depth_;
  std::vector<double>&dx = x_[at], &df = f_[at];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t offset = axis * n;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = offset + k;
      dx[i] = nodes[k] * (input_[i] - last_input_[i]);
      df[i] = nodes[k] > 0.0 ? next_[i] - residual_[i] : 0.0;
    }
  }
  const double moved = dot(dx, dx), changed = dot(df, df);
  const bool was_first = std::exchange(first_, false);
  if (!(moved > 0.0 && changed > 0.0)) return;
  // Other nodes, which a step or a contact puts in place, may have changed the residual much more than these changes
  // did.
  const bool is_clean = !was_first && &nodes == &root_;
  if (!is_clean && moved < min_change * min_change * dot(next_, next_)) return;
  // Great changes at the start, or at a change of contact, may be steeper than the network near the solution.
  if (++slopes_ == slopes_after_first) steepest_ = later_steepest_;
  const double slope = std::sqrt(changed / moved);
  steepest_ = std::max(steepest_, slope);
  if (is_clean) later_steepest_ = std::max(later_steepest_, slope);
  if (was_first) return;
  newest_ = at;
  count_ = std::min(count_ + 1, depth_);
  for (std::size_t age = 0; age < count_; ++age) {
    const std::size_t other = slot(age);
    gram_[at][other] = gram_[other][at] = age == 0 ? changed : dot(f_[other], df);
  }
}

void Anderson::solve() noexcept {
  // Cholesky factor of the Gram matrix scaled to a diagonal of ones, newest difference first.
  std::array<std::array<double, max_depth>, max_depth> factor{};
  std::array<double, max_depth> scale{}, right{};
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t row = slot(i);
    scale[i] = 1.0 / std::sqrt(gram_[row][row]);
    double left = 1.0;
    for (std::size_t j = 0; j < i; ++j) {
      double entry = gram_[row][slot(j)] * scale[i] * scale[j];
      for (std::size_t k = 0; k < j; ++k) entry -= factor[i][k] * factor[j][k];
      factor[i][j] = entry / factor[j][j];
      left -= factor[i][j] * factor[i][j];
    }
    if (!(left > min_independent)) {
      count_ = i;
      break;
    }
    factor[i][i] = std::sqrt(left);
    right[i] = dot(f_[row], residual_) * scale[i];
    for (std::size_t j = 0; j < i; ++j) right[i] -= factor[i][j] * right[j];
    right[i] /= factor[i][i];
  }
  for (std::size_t i = count_; i-- > 0;) {
    for (std::size_t j = i + 1; j < count_; ++j) right[i] -= factor[j][i] * right[j];
    right[i] /= factor[i][i];
  }
  for (std::size_t i = 0; i < count_; ++i) coefficients_[i] = right[i] * scale[i];
}

void Anderson::keep_best(const springnet_state& outputs, double norm) {
  best_norm_ = norm;
  since_best_ = 0;
  copy_to(outputs.position, best_position_);
  copy_to(outputs.velocity, best_velocity_);
  best_residual_ = residual_;
}

void Anderson::go_back(Step& step) {
  step.finite = true;
  if (std::isfinite(best_norm_)) {
    copy_from(best_position_, step.outputs->position);
    copy_from(best_velocity_, step.outputs->velocity);
    residual_ = best_residual_;
    max_damping_ *= 0.5;
    damping_ = std::min(damping_, max_damping_);
  } else {
    go_to_start(step);
    std::fill(residual_.begin(), residual_.end(), 0.0);
    first_ = false;
    start_norm_ = infinity;
  }
  if (relaxes_) {  // another map
    step.relaxation *= less_relaxation;
    best_norm_ *= less_relaxation;
    steepest_ = later_steepest_ = 0.0;
  }
  count_ = 0;
  since_best_ = 0;
  has_last_ = false;
  went_back_ = true;
  if (!given_up_) return;
  step.keeps_order = step.waits = false;
  step.relaxation = 1.0;
}

void Anderson::go_to_start(Step& step) const {
  const double w = step.weight();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double *u = axes(step.outputs->velocity)[axis], *p = axes(step.outputs->position)[axis];
    const double* free_position = axes(step.free_position)[axis];
    for (std::size_t k = 0; k < root_.size(); ++k) {
      if (step.network.fixed[k] != 0) continue;
      u[k] = axes(step.start.velocity)[axis][k];
      p[k] = status_[k] == free_node ? free_position[k] + w * u[k] : axes(step.start.position)[axis][k];
    }
  }
}

void Anderson::mix(Step& step) {
  if (!is_on() || given_up_) return;
  solve();
  const std::size_t n = root_.size();
  const double b = damping_, w = step.weight();
  std::swap(input_, last_input_);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double *u = axes(step.outputs->velocity)[axis], *p = axes(step.outputs->position)[axis];
    const double* start = axes(step.free_position)[axis];
    double* change = next_.data() + axis * n;
    const double* f = residual_.data() + axis * n;
    for (std::size_t k = 0; k < n; ++k) change[k] = (b - 1.0) * f[k];
    for (std::size_t age = 0; age < count_; ++age) {
      const double c = coefficients_[age];
      const double *dx = x_[slot(age)].data() + axis * n, *df = f_[slot(age)].data() + axis * n;
      for (std::size_t k = 0; k < n; ++k) change[k] -= c * (dx[k] + b * df[k]);
    }
    for (std::size_t k = 0; k < n; ++k) {
      if (root_[k] == 0.0) continue;
      const double du = change[k] / root_[k];
      u[k] += du;
      // In contact and on rigid connections positions follow to first order; the next sweep puts its own in place.
      p[k] = status_[k] == free_node ? start[k] + w * u[k] : p[k] + w * du;
    }
    std::copy_n(u, n, input_.data() + axis * n);
  }
}

}  // namespace springnet::recurrent
