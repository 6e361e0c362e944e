// Kinks of linear tables: entries at which the velocity of a motion jumps.
#pragma once

#include <cstddef>

#include <springnet/network.hpp>

namespace springnet {

struct Kinks {
  std::size_t entries = 0;  // number of entries of the table
  std::size_t count = 0;    // number of those at which the velocity jumps
  double greatest = 0.0;    // m/s or rad/s: the greatest jump

  // Tables of up to three entries are written by hand and their kinks intended; longer ones look like samples of a
  // smooth motion.
  [[nodiscard]] bool look_sampled() const noexcept { return entries > 3 && count >= 2; }
};
// Motions other than linear tables have no kinks.
[[nodiscard]] Kinks kinks_of(const Motion& motion);
[[nodiscard]] Kinks kinks_of(const Turn& turn);

}  // namespace springnet
