#include "check/pole.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace springnet::check {
namespace {

// nan counts as nothing, an infinite value as the greatest.
double size_of(double value) { return std::isnan(value) ? -1.0 : std::abs(value); }

// Where the size is greatest between two points, to rounding.
struct Peak {
  double at, size;
};
Peak narrow(const Curve& curve, double low, double high) {
  constexpr int parts = 16, most_rounds = 30;
  Peak peak{low, -1.0};
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<double> xs;
    for (int k = 0; k <= parts; ++k) xs.push_back(low + (high - low) * k / parts);
    const std::vector<double> values = curve(xs);
    std::size_t best = 0;
    for (std::size_t k = 1; k < values.size(); ++k)
      if (size_of(values[k]) > size_of(values[best])) best = k;
    if (values.empty()) return peak;
    if (size_of(values[best]) > peak.size) peak = {xs[best], size_of(values[best])};
    low = xs[best == 0 ? 0 : best - 1];
    high = xs[std::min(best + 1, xs.size() - 1)];
    if (high - low <= 8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(low), std::abs(high))) break;
  }
  return peak;
}

}  // namespace

std::optional<Pole> find_pole(const Curve& curve, const std::vector<double>& grid, const std::vector<double>& values) {
  // From a neighbour on the grid to rounding a pole grows by more than this, even one of the order 1/2.
  constexpr double growth = 1e4;
  constexpr double aside = 1e-6;
  for (std::size_t k = 0; k + 1 < grid.size(); ++k) {
    const double here = values[k], next = values[k + 1];
    const bool crosses = std::isfinite(here) && std::isfinite(next) && here * next < 0.0;
    const bool peaks = k > 0 && size_of(here) > size_of(values[k - 1]) && size_of(here) >= size_of(next);
    if (!crosses && !peaks) continue;
    const std::size_t first = k > 0 ? k - 1 : k, last = std::min(crosses ? k + 2 : k + 1, grid.size() - 1);
    const double outside =
        std::max({size_of(values[first]), size_of(values[last]), std::numeric_limits<double>::min()});
    if (!std::isfinite(values[first]) || !std::isfinite(values[last])) continue;
    const Peak peak = narrow(curve, grid[first], grid[last]);
    if (!(peak.size > growth * outside)) continue;
    const double off = aside * (grid[last] - grid[first]), further = std::sqrt(aside) * (grid[last] - grid[first]);
    const std::vector<double> sides = curve({peak.at - further, peak.at - off, peak.at + off, peak.at + further});
    if (sides.size() != 4 || !std::isfinite(sides[1]) || !std::isfinite(sides[2])) continue;
    // From both sides: at the end of a peak, or at a jump, only one would be large. And towards it: else it is noise.
    const double below = std::abs(sides[1]), above = std::abs(sides[2]);
    const bool grows = size_of(sides[0]) < below && size_of(sides[3]) < above && std::max(below, above) < peak.size;
    if (grows && std::min(below, above) > 10.0 * outside) return Pole{peak.at, sides[1], sides[2]};
  }
  return {};
}

}  // namespace springnet::check
