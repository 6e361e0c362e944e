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

// C. J. F. Ridders, Adv. Eng. Softw. 4 (1982) 75-76: of the table of extrapolations the entry whose neighbours differ
// least. floors: rounding error of each difference.
Slope extrapolate(const std::array<double, levels>& differences, const std::array<double, levels>& floors) {
  std::array<std::array<double, levels>, levels> table{};
  Slope best{std::numeric_limits<double>::quiet_NaN(), infinite};
  for (std::size_t i = 0; i < levels; ++i) {
    table[0][i] = differences[i];
    double factor = ratio * ratio, growth = 1.0;
    for (std::size_t j = 1; j <= i; ++j) {
      table[j][i] = (table[j - 1][i] * factor - table[j - 1][i - 1]) / (factor - 1.0);
      // Extrapolation adds up the rounding of its two terms.
      growth *= (factor + 1.0) / (factor - 1.0);
      const double error =
          std::max(std::abs(table[j][i] - table[j - 1][i]), std::abs(table[j][i] - table[j - 1][i - 1])) +
          growth * floors[i];
      if (std::isfinite(error) && error <= best.error) best = {table[j][i], error};
      factor *= ratio * ratio;
    }
  }
  return best;
}

}  // namespace

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
      slope.error = infinite;
      continue;
    }
    std::array<double, levels> central{}, floors{};
    for (std::size_t k = 0; k < levels; ++k) {
      const double low = f[1 + 2 * k], high = f[2 + 2 * k];
      central[k] = (high - low) / (above[k] + below[k]);
      floors[k] = rounding * (std::abs(low) + std::abs(high) + std::abs(f[0])) / above[k];
    }
    slope = extrapolate(central, floors);
  }
  return result;
}

}  // namespace springnet::check
