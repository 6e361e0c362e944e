#include "validation/error_norm.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace springnet {

void ErrorNorm::add(double time, const ConstNodeMap& positions, const std::vector<std::uint32_t>& columns,
                    const ConstNodeMap& reference, const std::vector<std::uint32_t>& reference_columns) {
  double greatest = 0.0;
  for (NodeIndex node = 0; node < columns.size(); ++node) {
    const Vector3 difference = positions.col(static_cast<Eigen::Index>(columns[node])) -
                               reference.col(static_cast<Eigen::Index>(reference_columns[node]));
    const double distance = difference.norm();
    // Negated, so that nan, which compares false with everything, is kept.
    if (!(distance <= greatest)) greatest = distance;
    if (!(distance <= error_.max) && !std::isnan(error_.max)) {
      error_.max = distance;
      error_.node = node;
      error_.time = time;
    }
    if (time > 0.0) squares_ += distance * distance;
  }
  if (time > 0.0) count_ += static_cast<double>(columns.size());
  error_.max_by_time.push_back(greatest);
}

PositionError ErrorNorm::result() const {
  PositionError result = error_;
  result.rms = std::sqrt(squares_ / count_);  // 0 / 0 is nan
  if (count_ == 0.0) result.max = std::numeric_limits<double>::quiet_NaN();
  return result;
}

double observed_order(const std::vector<double>& time_steps, const std::vector<double>& errors, double floor) {
  double count = 0.0, sum_x = 0.0, sum_y = 0.0;
  const auto usable = [&](std::size_t k) {
    return std::isfinite(errors[k]) && errors[k] > floor && time_steps[k] > 0.0;
  };
  for (std::size_t k = 0; k < std::min(time_steps.size(), errors.size()); ++k) {
    if (!usable(k)) continue;
    count += 1.0;
    sum_x += std::log(time_steps[k]);
    sum_y += std::log(errors[k]);
  }
  double covariance = 0.0, variance = 0.0;
  for (std::size_t k = 0; k < std::min(time_steps.size(), errors.size()); ++k) {
    if (!usable(k)) continue;
    const double x = std::log(time_steps[k]) - sum_x / count;
    covariance += x * (std::log(errors[k]) - sum_y / count);
    variance += x * x;
  }
  return variance > 0.0 ? covariance / variance : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace springnet
