#include "figure/axis.hpp"

#include <cmath>

namespace springnet::figure {

Axis::Axis(Interval values, bool is_logarithmic, double first, double last, double wanted_ticks)
    : is_logarithmic_(is_logarithmic),
      low_(scaled(values.low)),
      high_(scaled(values.high)),
      first_(first),
      last_(last),
      wanted_ticks_(wanted_ticks) {
  constexpr double around = 0.15, least = 1.0;  // decades
  if (!is_logarithmic) return;
  low_ -= around;
  high_ += around;
  const double missing = std::max(0.0, least - (high_ - low_));
  low_ -= missing / 2.0;
  high_ += missing / 2.0;
}

double Axis::low() const { return is_logarithmic_ ? std::pow(10.0, low_) : low_; }
double Axis::high() const { return is_logarithmic_ ? std::pow(10.0, high_) : high_; }
double Axis::scaled(double value) const { return is_logarithmic_ ? std::log10(value) : value; }

std::vector<Tick> Axis::even_ticks() const {
  const double raw = (high_ - low_) / wanted_ticks_;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * power >= raw * (1.0 - 1e-9)) step = factor * power;
  std::vector<Tick> ticks;
  for (double k = std::ceil(low_ / step - 1e-9); k * step <= high_ + 1e-9 * step; k += 1.0)
    ticks.push_back({k * step + 0.0, true});  // + 0.0: no "-0"
  return ticks;
}

std::vector<Tick> Axis::ticks_of_decades() const {
  const double decades = high_ - low_;
  const double every = std::ceil(decades / 8.0);
  std::vector<Tick> ticks;
  for (double decade = std::floor(low_); decade <= std::ceil(high_); decade += 1.0) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * std::pow(10.0, decade);
      const double at = std::log10(value);
      if (at < low_ || at > high_) continue;
      const bool whole = factor == 1.0;
      if (!whole && decades > 3.5) continue;
      ticks.push_back({value, whole ? std::fmod(std::abs(decade), every) == 0.0 : decades < 2.2});
    }
  }
  return ticks;
}

}  // namespace springnet::figure
