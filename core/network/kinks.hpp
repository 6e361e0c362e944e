// Kinks of linear tables: where the velocity of a motion jumps.
#pragma once

#include <cstddef>

#include <springnet/network.hpp>

namespace springnet {

struct Kinks {
  std::size_t entries = 0;  // of the table
  std::size_t count = 0;    // of those at which the velocity jumps
  double greatest = 0.0;    // m/s or rad/s: the greatest jump

  // So many entries are written by hand, and their kinks meant; more look like samples of a smooth motion.
  [[nodiscard]] bool look_sampled() const noexcept { return entries > 3 && count >= 2; }
};
// None of motions that are not linear tables.
[[nodiscard]] Kinks kinks_of(const Motion& motion);
[[nodiscard]] Kinks kinks_of(const Turn& turn);

}  // namespace springnet
