#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <springnet/output.hpp>

#include "output/csv_file.hpp"

namespace springnet {

namespace {

// Characters of a number with 17 significant digits, sign, decimal point and leading zero, and of its comma. Shortest
// decimals of doubles have 16 or 17 digits mostly; leading zeros or an exponent make some longer.
constexpr double number_length = 22.0;
// Multiples of a time step have fewer digits than the worst.
constexpr double time_length = 18.0;

double digits_of(double count) { return std::floor(std::log10(std::max(count - 1.0, 1.0))) + 1.0; }

// Characters of the names of all surfaces and their commas, or of their numbers.
double name_lengths(const Network& network) {
  double sum = 0.0;
  double number = 0.0;
  const auto add = [&](const auto& surface) {
    number += 1.0;
    sum += 1.0 + (surface.name.empty() ? digits_of(number) : static_cast<double>(csv_cell(surface.name).size()));
  };
  for (const Plane& plane : network.planes()) add(plane);
  for (const Instrument& instrument : network.instruments()) add(instrument);
  return sum;
}

}  // namespace

OutputEstimate estimate_output(const Scene& scene) {
  const double interval = std::max(scene.output.interval, scene.options.time_step);
  // One at the start, one each interval, and one at the end where that falls between.
  const double intervals = scene.duration / interval;
  const double whole = std::floor(intervals * (1.0 + 1e-12));
  const double records = whole + 1.0 + (intervals - whole > 1e-9 * intervals ? 1.0 : 0.0);
  const auto nodes = static_cast<double>(scene.network.nodes().size());
  const auto fixed = static_cast<double>(
      std::count_if(scene.network.nodes().begin(), scene.network.nodes().end(), [](const Node& n) { return n.fixed; }));
  const auto surfaces = static_cast<double>(scene.network.planes().size() + scene.network.instruments().size());
  const double row_start = time_length + digits_of(nodes) + 1.0;

  double record = 0.0;
  if (scene.output.trajectory) record += nodes * (row_start + 6.0 * number_length + 1.0);
  if (scene.output.reactions) {
    // Any node may come to rest on a surface.
    const double rows = surfaces > 0 ? nodes : fixed;
    record += rows * (row_start + 6.0 * number_length + 1.0);
  }
  if (scene.output.surfaces) {
    record += surfaces * (time_length + 9.0 * number_length + digits_of(nodes) + 2.0) + name_lengths(scene.network);
  }
  if (scene.output.rigid) {
    const auto rigids = static_cast<double>(scene.network.rigids().size());
    record += rigids * (time_length + digits_of(rigids) + number_length + 2.0);
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
