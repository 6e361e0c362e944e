// When a coarse space that is kept from system to system is made anew: once the iterations beyond those of a new one
// add up to the cost of making it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <springnet/sdk/math.hpp>

#include "layers/linear/block_system.hpp"
#include "layers/linear/conjugate_gradients.hpp"

namespace springnet::layers {

class CoarseUse {
 public:
  // With a new one, for a system of these weights.
  void begin(const SystemWeights& weights) noexcept {
    weights_ = weights;
    begin_again();
  }
  void begin_again() noexcept {
    solutions_ = 0;
    excess_ = 0.0;
  }
  [[nodiscard]] bool serves(const SystemWeights& weights) const noexcept {
    // Steps of equal length differ by the rounding of their ends.
    const auto same = [](double a, double b) { return std::abs(a - b) <= 1e-9 * std::abs(b); };
    return same(weights.velocity, weights_.velocity) && same(weights.position, weights_.position) &&
           same(weights.shift, weights_.shift) && excess_ < cost_of_renewal;
  }
  // After a solution. products: of the matrix, in an iteration.
  void count(const SolveAnswer& answer, double products) noexcept {
    const double reduction = -sdk::log(answer.residual);
    if (!(reduction > 0.0) || !std::isfinite(reduction)) return;
    const double work = products * answer.iterations;
    const double own = work / reduction;
    mean_ = solutions_ == 0 ? own : mean_ + share_of_new * (own - mean_);
    least_ = solutions_ < solutions_of_new ? mean_ : std::min(least_, mean_);
    if (solutions_ < solutions_of_new) ++solutions_;
    excess_ += work - least_ * reduction;
  }

 private:
  static constexpr double cost_of_renewal = 30.0;  // products
  static constexpr int solutions_of_new = 3;       // until the mean says something
  static constexpr double share_of_new = 0.3;
  SystemWeights weights_;
  int solutions_ = 0;
  double mean_ = 0.0, least_ = 0.0;  // products by the logarithm of the reduction, of the last solutions
  double excess_ = 0.0;              // products beyond the least, since the last renewal
};

}  // namespace springnet::layers
