// When a coarse space that is kept from system to system is made anew: once the iterations beyond those of a new one
// add up to the cost of making it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <springnet/sdk/math.hpp>

#include "layers/linear/block_system.hpp"
#include "layers/linear/conjugate_gradients.hpp"

namespace springnet::layers {

class CoarseUse {
 public:
  // With a new one, for a system of these weights with so many springs; numbers: of the small system.
  void begin(const SystemWeights& weights, std::size_t springs, std::size_t numbers) noexcept {
    weights_ = weights;
    const auto n = static_cast<double>(numbers), each = static_cast<double>(std::max<std::size_t>(springs, 1));
    cost_ = cost_of_sums + cost_of_factors * n * n * n / each;
    begin_again();
  }
  void begin_again() noexcept {
    solutions_ = 0;
    excess_ = 0.0;
  }
  [[nodiscard]] bool serves(const SystemWeights& weights) const noexcept {
    return are_same(weights, weights_) && excess_ < cost_;
  }
  // Steps of equal length differ by the rounding of their ends.
  [[nodiscard]] static bool are_same(const SystemWeights& a, const SystemWeights& b) noexcept {
    const auto same = [](double x, double y) { return std::abs(x - y) <= 1e-9 * std::abs(y); };
    return same(a.velocity, b.velocity) && same(a.position, b.position) && same(a.shift, b.shift);
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
  // In products of the matrix: of the sums over springs, and of the factors, by the numbers cubed for each spring.
  // (Measured: 20 and 90 with 34,000 springs and 384 numbers.)
  static constexpr double cost_of_sums = 20.0, cost_of_factors = 0.055;
  static constexpr int solutions_of_new = 3;  // until the mean says something
  static constexpr double share_of_new = 0.3;
  SystemWeights weights_;
  double cost_ = 0.0;  // of a new one, products
  int solutions_ = 0;
  double mean_ = 0.0, least_ = 0.0;  // products by the logarithm of the reduction, of the last solutions
  double excess_ = 0.0;              // products beyond the least, since the last renewal
};

}  // namespace springnet::layers
