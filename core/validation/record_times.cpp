#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/validation.hpp>

namespace springnet {

namespace {

bool divides(double time_step, double interval) {
  const double steps = interval / time_step;
  // Quotients of decimal fractions such as 0.05 / 0.0125 are whole numbers up to a few rounding errors.
  return std::round(steps) >= 1.0 && std::abs(steps - std::round(steps)) <= 1e-9 * steps;
}

}  // namespace

RecordTimes common_record_times(double duration, double wanted_interval, const std::vector<double>& time_steps) {
  for (const double time_step : time_steps) {
    if (!(time_step > 0.0) || !(time_step <= duration)) {
      throw Error(
          ErrorKind::input,
          fmt::format("time step {:.10g} s: must be above 0 and at most the duration, {:.10g} s", time_step, duration));
    }
  }
  const double coarsest = *std::max_element(time_steps.begin(), time_steps.end());
  const double wanted = std::max(1.0, std::round(wanted_interval / coarsest));
  const auto all_divide = [&](double interval) {
    return std::all_of(time_steps.begin(), time_steps.end(), [&](double t) { return divides(t, interval); });
  };

  double interval = wanted * coarsest;
  for (double factor = wanted; factor <= 16.0 * wanted && factor * coarsest <= duration; factor += 1.0) {
    if (!all_divide(factor * coarsest)) continue;
    interval = factor * coarsest;
    break;
  }

  RecordTimes result;
  for (const double time_step : time_steps) {
    if (!divides(time_step, interval)) result.shortened_time_steps.push_back(time_step);
  }
  const double count = std::floor(duration / interval * (1.0 + 1e-12));
  for (double k = 0.0; k <= count; k += 1.0) result.times.push_back(std::min(k * interval, duration));
  if (duration - result.times.back() > 1e-9 * interval) {
    result.times.push_back(duration);
  } else {
    result.times.back() = duration;
  }
  return result;
}

}  // namespace springnet
