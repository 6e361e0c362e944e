#include "anderson.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "columns.hpp"

namespace springnet::recurrent {
namespace {

// The residual may grow by this over the smallest one: on a linear network by at most |G|, for a sweep.
constexpr double max_growth = 10.0;
constexpr int max_retreats = 8;  // then plain sweeps
constexpr int patience = 40;     // sweeps without a smaller residual, then plain sweeps
// A difference of which the newer ones leave less than this, squared and relative, is dropped.
constexpr double min_independent = 1e-12;

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
  for (auto* values : {&input_, &last_input_, &residual_, &next_, &best_position_, &best_velocity_, &best_residual_})
    values->resize(size);
  x_.resize(depth_);
  f_.resize(depth_);
  for (std::size_t i = 0; i < depth_; ++i) {
    x_[i].resize(size);
    f_[i].resize(size);
  }
}

void Anderson::begin(Step& step) {
  if (!is_on()) return;
  count_ = 0;
  has_last_ = went_back_ = given_up_ = false;
  first_ = true;
  best_norm_ = std::numeric_limits<double>::infinity();
  steepest_ = 0.0;
  damping_ = max_damping_ = 1.0;
  retreats_ = since_best_ = 0;
  step.keeps_order = true;
  static_cast<void>(find_free(step));
  copy_to(step.newest().velocity, input_);
}

bool Anderson::moves_freely(const springnet_network& network, std::uint32_t node) const noexcept {
  return network.fixed[node] == 0 && network.held[node] == 0 && network.touching[node] == 0 &&
         network.cluster[node] == no_node && network.status[node] == SPRINGNET_FREE;
}

bool Anderson::find_free(const Step& step) {
  bool changed = false;
  for (std::uint32_t k = 0; k < step.network.node_count; ++k) {
    const bool free = moves_freely(step.network, k);
    if (free == (root_[k] > 0.0)) continue;
    root_[k] = free ? std::sqrt(step.network.mass[k]) : 0.0;
    changed = true;
  }
  return changed;
}

bool Anderson::record(Step& step) {
  if (!is_on() || given_up_) return step.finite;
  went_back_ = false;
  double norm = std::numeric_limits<double>::infinity();
  if (step.finite) {
    if (step.constrained() && find_free(step)) {
      count_ = 0;
      has_last_ = false;
      best_norm_ = std::numeric_limits<double>::infinity();
    }
    const std::size_t n = root_.size();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double* u = axes(step.outputs->velocity)[axis];
      const double* input = input_.data() + axis * n;
      double* f = next_.data() + axis * n;
      for (std::size_t k = 0; k < n; ++k) f[k] = root_[k] * (u[k] - input[k]);
    }
    norm = std::sqrt(dot(next_, next_));
    if (std::isfinite(norm) && has_last_) add_difference();
    has_last_ = true;
  }
  damping_ = std::min(max_damping_, 2.0 / (1.0 + std::max(1.0, steepest_)));
  // Negated: not finite is too much.
  const bool grew = !(norm <= max_growth * best_norm_) || !std::isfinite(norm);
  if (grew || ++since_best_ > patience) {
    if (!std::isfinite(best_norm_)) return step.finite;
    given_up_ = !grew || ++retreats_ > max_retreats;
    go_back(step);
    return true;
  }
  std::swap(residual_, next_);
  if (norm < best_norm_) keep_best(*step.outputs, norm);
  return true;
}

void Anderson::add_difference() {
  const std::size_t n = root_.size();
  const std::size_t at = (newest_ + 1) % depth_;
  std::vector<double>&dx = x_[at], &df = f_[at];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t offset = axis * n;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t i = offset + k;
      dx[i] = root_[k] * (input_[i] - last_input_[i]);
      df[i] = next_[i] - residual_[i];
    }
  }
  const double moved = dot(dx, dx), changed = dot(df, df);
  if (!(moved > 0.0 && changed > 0.0)) return;
  steepest_ = std::max(steepest_, std::sqrt(changed / moved));
  if (first_) {
    first_ = false;
    return;
  }
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
  copy_from(best_position_, step.outputs->position);
  copy_from(best_velocity_, step.outputs->velocity);
  step.finite = true;
  residual_ = best_residual_;
  max_damping_ *= 0.5;
  damping_ = std::min(damping_, max_damping_);
  count_ = 0;
  since_best_ = 0;
  has_last_ = false;
  went_back_ = true;
  if (given_up_) step.keeps_order = false;
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
      u[k] += change[k] / root_[k];
      p[k] = start[k] + w * u[k];
    }
    std::copy_n(u, n, input_.data() + axis * n);
  }
}

}  // namespace springnet::recurrent
