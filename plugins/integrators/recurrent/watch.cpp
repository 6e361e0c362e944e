#include "watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "columns.hpp"

namespace springnet::recurrent {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
// Sweeps that contract less than this tell nothing about what is left.
constexpr double slowest_rate = 0.95;

void store(const springnet_vectors& from, std::size_t n, std::vector<double>& to) {
  to.resize(3 * n);
  for (std::size_t axis = 0; axis < 3; ++axis)
    std::copy_n(axes(from)[axis], n, to.begin() + static_cast<std::ptrdiff_t>(axis * n));
}

void restore(const std::vector<double>& from, std::size_t n, const springnet_vectors& to) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(axis * n), n, axes(to)[axis]);
}

// By which outputs are compared: the residual where the rule knows it, else the last difference of forces.
double measure(const Step& step) noexcept { return step.evaluated ? step.residual : step.differences.greatest; }

}  // namespace

void Watch::begin(const Step& step) {
  left_ = host_.time_left();
  active_ = std::isfinite(left_);
  if (!active_) return;
  duration_ = 0.0;
  best_ = std::numeric_limits<double>::infinity();
  newest_is_best_ = true;
  change_ = last_change_ = unknown;
  store(step.newest().position, step.network.node_count, position_);
}

void Watch::after_sweep(const Step& step) {
  if (!active_) return;
  const std::size_t n = step.network.node_count;
  const springnet_vectors& p = step.outputs->position;
  double square = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const double x = p.x[k] - position_[k], y = p.y[k] - position_[n + k], z = p.z[k] - position_[2 * n + k];
    square = std::max(square, x * x + y * y + z * z);
  }
  last_change_ = change_;
  change_ = std::sqrt(square);
  store(p, n, position_);
  newest_is_best_ = step.constrained() || !(measure(step) > best_);
  if (newest_is_best_ && !step.is_provisional) keep(step);
  const double now = host_.time_left();
  duration_ = std::max(0.0, left_ - now);
  left_ = now;
}

void Watch::keep(const Step& step) {
  best_ = step.constrained() ? std::numeric_limits<double>::infinity() : measure(step);
  if (step.constrained()) return;
  best_position_ = position_;
  store(step.outputs->velocity, step.network.node_count, best_velocity_);
}

void Watch::take_best(Step& step) const {
  if (!active_ || newest_is_best_) return;
  restore(best_position_, step.network.node_count, step.outputs->position);
  restore(best_velocity_, step.network.node_count, step.outputs->velocity);
  step.evaluated = false;
}

double Watch::position_error(const Step& step) const {
  if (!active_) return unknown;
  const springnet_network& network = step.network;
  // The system that is left, A e = -r with A = I + w D + w^2 K, has A >= I in the norm of the masses where nothing
  // softens: |e| <= |r|.
  double lightest = std::numeric_limits<double>::infinity();
  for (std::uint32_t k = 0; k < network.node_count; ++k)
    if (network.fixed[k] == 0) lightest = std::min(lightest, network.mass[k]);
  const double bound = step.weight() * step.norm / std::sqrt(lightest);
  // Changes that contract like a geometric series.
  double rate = std::isfinite(last_change_) && last_change_ > 0.0 ? change_ / last_change_ : unknown;
  if (std::isfinite(step.rate)) rate = std::isfinite(rate) ? std::max(rate, step.rate) : step.rate;
  if (!newest_is_best_ || !(rate < slowest_rate)) return bound;
  const double estimate = change_ * rate / (1.0 - rate);
  return bound < estimate ? bound : estimate;
}

}  // namespace springnet::recurrent
