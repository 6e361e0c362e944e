// Shared parts of the network's input checks.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/network.hpp>

namespace springnet::checks {

// Numbers of nodes, springs, elements and rigid connections have 32 bits; the largest stands for "none".
inline constexpr std::size_t max_count = std::numeric_limits<std::uint32_t>::max();

[[noreturn]] inline void fail(const std::string& message) { throw Error(ErrorKind::input, message); }

inline std::string text(const Vector3& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

// "0.57 s", without rounding digits as of 57 * 0.01; infinities and NaN in words.
inline std::string seconds(double time) {
  if (std::isfinite(time)) return fmt::format("{:.10g} s", time);
  return std::isnan(time) ? "not a number" : time > 0.0 ? "infinity" : "minus infinity";
}

inline double distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a.x() - b.x(), a.y() - b.y(), a.z() - b.z());
}

// A direction with length 1. One that has it, up to rounding, keeps its bits, so that what is written and read again
// stays the same.
inline Vector3 to_unit(const Vector3& direction) {
  constexpr double rounding = 8.0 * std::numeric_limits<double>::epsilon();
  return std::abs(direction.squaredNorm() - 1.0) <= rounding ? direction : direction.stableNormalized();
}

inline void check_finite(const Vector3& v, std::string_view what) {
  if (!v.allFinite()) fail(fmt::format("{} must be finite, is {}", what, text(v)));
}

// A program may have cast any number to it.
inline void check_interpolation(Motion::Interpolation interpolation, std::string_view what) {
  if (interpolation != Motion::Interpolation::linear && interpolation != Motion::Interpolation::smooth)
    fail(fmt::format("{} has the unknown interpolation {}: give linear or smooth", what,
                     static_cast<int>(interpolation)));
}

// Sorts and removes duplicates.
inline void sort(std::vector<NodeIndex>& nodes) {
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

// Checks the times of a table with `count` entries of `values`.
inline void check_times(const std::vector<double>& times, std::size_t count, std::string_view values,
                        std::string_view what) {
  if (times.size() != count) {
    fail(fmt::format("{}: its table has {} times and {} {}: give equal numbers of both", what, times.size(), count,
                     values));
  }
  if (count < 2) fail(fmt::format("{}: its table needs two entries or more, has {}", what, count));
  for (std::size_t k = 0; k < count; ++k) {
    if (!std::isfinite(times[k])) {
      fail(fmt::format("{}: a time must be finite, entry {} of its table is {}", what, k, seconds(times[k])));
    }
    if (k > 0 && !(times[k - 1] < times[k])) {
      fail(fmt::format("{}: the times of its table must increase, but entry {} is at {} and entry {} at {}", what,
                       k - 1, seconds(times[k - 1]), k, seconds(times[k])));
    }
  }
}
// Throws Error(input) if the lattice is not finite, would exceed the largest node or spring number together with those
// that exist, or does not fit into this machine's memory.
void check_lattice(const std::string& name, const Lattice& lattice, std::size_t existing_nodes,
                   std::size_t existing_springs);

}  // namespace springnet::checks
