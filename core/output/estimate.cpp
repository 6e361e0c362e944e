#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <springnet/output.hpp>

namespace springnet {

namespace {

// Characters of a number with 17 significant digits, sign, decimal point and leading zero, and of its comma. Shortest
// decimals of doubles have 16 or 17 digits mostly; leading zeros or an exponent make some longer.
constexpr double number_length = 22.0;
// Multiples of a time step have fewer digits than the worst.
constexpr double time_length = 18.0;

double digits_of(double count) { return std::floor(std::log10(std::max(count - 1.0, 1.0))) + 1.0; }

}  // namespace

OutputEstimate estimate_output(const Scene& scene) {
  const double interval = std::max(scene.output.interval, scene.options.time_step);
  const double records = std::floor(scene.duration / interval * (1.0 + 1e-12)) + 2.0;
  const auto nodes = static_cast<double>(scene.network.nodes().size());
  const auto fixed = static_cast<double>(
      std::count_if(scene.network.nodes().begin(), scene.network.nodes().end(), [](const Node& n) { return n.fixed; }));
  const double row_start = time_length + digits_of(nodes) + 1.0;

  double record = 0.0;
  if (scene.output.trajectory) record += nodes * (row_start + 6.0 * number_length + 1.0);
  if (scene.output.reactions) {
    // Any node may come to rest on a plane.
    const double rows = scene.network.planes().empty() ? fixed : nodes;
    record += rows * (row_start + 3.0 * number_length + 1.0);
  }
  return {records, records * record};
}

std::string readable_bytes(double bytes) {
  constexpr std::array<const char*, 6> units{"bytes", "kB", "MB", "GB", "TB", "PB"};
  std::size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < units.size()) {
    bytes /= 1000.0;
    ++unit;
  }
  return unit == 0 ? fmt::format("{:.0f} bytes", bytes) : fmt::format("{:.3g} {}", bytes, units[unit]);
}

}  // namespace springnet
