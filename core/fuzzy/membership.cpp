#include <algorithm>
#include <cmath>

#include <springnet/sdk/math.hpp>

#include "fuzzy/functions.hpp"

namespace springnet::fuzzy {
namespace {

// The line from height `low` at a to `high` at b, a < b.
struct Ramp {
  double value, by_x, by_a, by_b;
};
Ramp ramp(double x, double a, double b, double low, double high) {
  const double share = (x - a) / (b - a), slope = (high - low) / (b - a);
  return {low + share * (high - low), slope, -slope * (1.0 - share), -slope * share};
}

void set(std::span<double> by_numbers, std::size_t number, double derivative) {
  if (!by_numbers.empty()) by_numbers[number] = derivative;
}

// Rises between numbers 0 and 1, is 1 up to the last but one, and falls to the last.
OfOne trapezoid(std::span<const double> at, double x, std::span<double> by_numbers) {
  const std::size_t last = at.size() - 1;
  if (x < at[0] || x > at[last]) return {};
  if (x < at[1]) {
    const Ramp up = ramp(x, at[0], at[1], 0.0, 1.0);
    set(by_numbers, 0, up.by_a);
    set(by_numbers, 1, up.by_b);
    return {up.value, up.by_x};
  }
  if (x <= at[last - 1]) return {1.0, 0.0};
  const Ramp down = ramp(x, at[last - 1], at[last], 1.0, 0.0);
  set(by_numbers, last - 1, down.by_a);
  set(by_numbers, last, down.by_b);
  return {down.value, down.by_x};
}

// Where two points have the same x, the later one counts from there on.
OfOne interpolate(std::span<const double> at, double x, std::span<double> by_numbers) {
  const std::size_t count = at.size() / 2;
  std::size_t next = 0;
  for (std::size_t end = count; next < end;) {
    const std::size_t middle = (next + end) / 2;
    if (at[2 * middle] <= x)
      next = middle + 1;
    else
      end = middle;
  }
  if (next == 0 || next == count) {
    const std::size_t point = next == 0 ? 0 : count - 1;
    set(by_numbers, 2 * point + 1, 1.0);
    return {at[2 * point + 1], 0.0};
  }
  const std::size_t before = 2 * (next - 1), after = 2 * next;
  const Ramp line = ramp(x, at[before], at[after], at[before + 1], at[after + 1]);
  const double share = (x - at[before]) / (at[after] - at[before]);
  set(by_numbers, before, line.by_a);
  set(by_numbers, after, line.by_b);
  set(by_numbers, before + 1, 1.0 - share);
  set(by_numbers, after + 1, share);
  return {line.value, line.by_x};
}

OfOne gaussian(double mean, double deviation, double x, std::span<double> by_numbers) {
  const double from_mean = (x - mean) / deviation;
  const double value = sdk::exp(-0.5 * from_mean * from_mean), by_x = -value * from_mean / deviation;
  set(by_numbers, 0, -by_x);
  set(by_numbers, 1, -by_x * from_mean);
  return {value, by_x};
}

OfOne sigmoid(double inflection, double slope, double x, std::span<double> by_numbers) {
  const double value = 1.0 / (1.0 + sdk::exp(-slope * (x - inflection))), by_argument = value * (1.0 - value);
  set(by_numbers, 0, -by_argument * slope);
  set(by_numbers, 1, by_argument * (x - inflection));
  return {value, by_argument * slope};
}

}  // namespace

OfOne membership(const Term& term, double x, std::span<double> by_numbers) {
  std::fill(by_numbers.begin(), by_numbers.end(), 0.0);
  switch (term.shape) {
    case Shape::triangle:
    case Shape::trapezoid:
      return trapezoid(term.numbers, x, by_numbers);
    case Shape::gaussian:
      return gaussian(term.numbers[0], term.numbers[1], x, by_numbers);
    case Shape::sigmoid:
      return sigmoid(term.numbers[0], term.numbers[1], x, by_numbers);
    case Shape::points:
      return interpolate(term.numbers, x, by_numbers);
    case Shape::singleton:
    case Shape::linear:
      break;  // check() lets none of them come here
  }
  return {};
}

}  // namespace springnet::fuzzy
