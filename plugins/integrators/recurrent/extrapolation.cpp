#include "extrapolation.hpp"

#include <algorithm>

#include "columns.hpp"

namespace springnet::recurrent {

std::array<double, 3> Extrapolation::weights(std::size_t latest, std::size_t order, double time) const {
  std::array<double, 3> result{};
  for (std::size_t i = 0; i <= order; ++i) {
    result[i] = 1.0;
    for (std::size_t j = 0; j <= order; ++j)
      if (j != i) result[i] *= (time - at(latest + j).time) / (at(latest + i).time - at(latest + j).time);
  }
  return result;
}

void Extrapolation::learn(double time, const springnet_const_vectors& velocity, std::uint32_t count) {
  const std::size_t size = 3 * std::size_t{count};
  if (known_ > 0 && (at(0).velocity.size() != size || !(time >= at(0).time))) known_ = 0;
  if (known_ > 0 && time == at(0).time) return;
  newest_ = (newest_ + 1) % kept;
  known_ = std::min(known_ + 1, kept);
  Known& now = steps_[newest_];
  now.time = time;
  now.velocity.resize(size);
  for (std::size_t axis = 0; axis < 3; ++axis)
    std::copy_n(axes(velocity)[axis], count, now.velocity.begin() + static_cast<std::ptrdiff_t>(axis * count));
  order_ = 0;
  double smallest = 0.0;
  // Of order `order` from the velocities before this one.
  for (std::size_t order = 0; order < 3 && order + 1 < known_; ++order) {
    const std::array<double, 3> w = weights(1, order, time);
    const double *a = at(1).velocity.data(), *b = at(std::min(known_ - 1, std::size_t{2})).velocity.data(),
                 *c = at(std::min(known_ - 1, std::size_t{3})).velocity.data();
    double error = 0.0;
    for (std::size_t i = 0; i < size; ++i) {
      const double difference = now.velocity[i] - (w[0] * a[i] + w[1] * b[i] + w[2] * c[i]);
      error += difference * difference;
    }
    if (order > 0 && !(error < smallest)) continue;
    smallest = error;
    order_ = order;
  }
}

bool Extrapolation::guess(double time, const springnet_vectors& velocity) const {
  if (known_ < 2 || known_ <= order_) return false;
  const std::array<double, 3> w = weights(0, order_, time);
  const double *a = at(0).velocity.data(), *b = at(1).velocity.data(),
               *c = at(std::min(known_ - 1, order_)).velocity.data();
  const std::size_t count = at(0).velocity.size() / 3;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = axis * count + k;
      axes(velocity)[axis][k] = w[0] * a[i] + w[1] * b[i] + w[2] * c[i];
    }
  return true;
}

}  // namespace springnet::recurrent
