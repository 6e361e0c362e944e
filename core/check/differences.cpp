#include "check/differences.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace springnet::check {
namespace {

constexpr std::size_t levels = 11;
constexpr double ratio = 1.7;  // of successive steps: the smallest is 1 / 200 of the first
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double rounding = 2.0 * std::numeric_limits<double>::epsilon();

struct Extrapolated {
  double value = std::numeric_limits<double>::quiet_NaN(), error = infinite;
};

// C. J. F. Ridders, Adv. Eng. Softw. 4 (1982) 75-76: of the table of extrapolations the entry whose neighbours differ
// least. power: of the step in the error's expansion. floors: rounding error of each difference.
Extrapolated extrapolate(const std::array<double, levels>& differences, const std::array<double, levels>& floors,
                         int power) {
  std::array<std::array<double, levels>, levels> table{};
  Extrapolated best;
  for (std::size_t i = 0; i < levels; ++i) {
    table[0][i] = differences[i];
    double factor = std::pow(ratio, power), growth = 1.0;
    for (std::size_t j = 1; j <= i; ++j) {
      table[j][i] = (table[j - 1][i] * factor - table[j - 1][i - 1]) / (factor - 1.0);
      // Extrapolation adds up the rounding of its two terms.
      growth *= (factor + 1.0) / (factor - 1.0);
      const double error =
          std::max(std::abs(table[j][i] - table[j - 1][i]), std::abs(table[j][i] - table[j - 1][i - 1])) +
          growth * floors[i];
      if (std::isfinite(error) && error <= best.error) best = {table[j][i], error};
      factor *= std::pow(ratio, power);
    }
  }
  return best;
}

}  // namespace

bool Slope::smooth(double size) const noexcept {
  if (!std::isfinite(left) || !std::isfinite(right)) return false;
  size = std::max({size, std::abs(left), std::abs(right)});
  return side_error <= 0.1 * size && std::abs(left - right) <= 4.0 * side_error + 1e-6 * size;
}

Verdict compare(double claimed, const Slope& slope) {
  // Digits to which differences of smooth formulas agree, and mistakes do not; the estimate leaves out what the formula
  // itself rounds.
  constexpr double agreement = 1e-6, safety = 30.0;
  if (!std::isfinite(slope.error) || !std::isfinite(slope.value)) return Verdict::undecided;
  const double size = std::max(std::abs(claimed), std::abs(slope.value));
  if (std::abs(claimed - slope.value) <= safety * slope.error + agreement * size) return Verdict::agrees;
  return slope.smooth(size) ? Verdict::differs : Verdict::undecided;  // at a kink any slope between the two is right
}

bool differs_for_all_steps(double claimed, const Functions& functions, std::size_t function, double x, double step) {
  for (const double part : {1.0, 0.02, 4e-4})
    if (compare(claimed, slopes(functions, x, part * step)[function]) != Verdict::differs) return false;
  return true;
}

std::vector<Slope> slopes(const Functions& functions, double x, double step) {
  // x, then x - h and x + h of each level; h as it is after rounding.
  std::vector<double> points{x};
  std::array<double, levels> below{}, above{};
  double h = step;
  for (std::size_t k = 0; k < levels; ++k, h /= ratio) {
    const double low = x - h, high = x + h;
    points.push_back(low);
    points.push_back(high);
    below[k] = x - points[1 + 2 * k];
    above[k] = points[2 + 2 * k] - x;
  }
  const std::vector<std::vector<double>> values = functions(points);
  std::vector<Slope> result;
  for (const std::vector<double>& f : values) {
    Slope& slope = result.emplace_back();
    if (f.empty()) {
      slope.error = slope.side_error = infinite;
      continue;
    }
    std::array<double, levels> central{}, left{}, right{}, floors{};
    for (std::size_t k = 0; k < levels; ++k) {
      const double low = f[1 + 2 * k], high = f[2 + 2 * k];
      central[k] = (high - low) / (above[k] + below[k]);
      left[k] = (f[0] - low) / below[k];
      right[k] = (high - f[0]) / above[k];
      floors[k] = rounding * (std::abs(low) + std::abs(high) + std::abs(f[0])) / above[k];
    }
    const Extrapolated middle = extrapolate(central, floors, 2), l = extrapolate(left, floors, 1),
                       r = extrapolate(right, floors, 1);
    slope = {middle.value, middle.error, l.value, r.value, l.error + r.error};
  }
  return result;
}

}  // namespace springnet::check
