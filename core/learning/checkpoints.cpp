#include "learning/checkpoints.hpp"

#include <algorithm>
#include <limits>

namespace springnet::learning {
namespace {

// binomial(places + times, times), or `most` if it is more; 0 of negative numbers.
std::size_t reached(std::ptrdiff_t places, std::ptrdiff_t times, std::size_t most) noexcept {
  if (places < 0 || times < 0) return 0;
  double result = 1.0;  // exact far beyond the number of steps of any run
  for (std::ptrdiff_t i = 1; i <= times; ++i) {
    result = result * static_cast<double>(places + i) / static_cast<double>(i);
    if (result >= static_cast<double>(most)) return most;
  }
  return static_cast<std::size_t>(result + 0.5);
}

// How often a part is made at most: the least r with binomial(places + r, r) >= parts.
std::ptrdiff_t most_times(std::size_t parts, std::size_t places) noexcept {
  std::ptrdiff_t r = 0;
  while (reached(static_cast<std::ptrdiff_t>(places), r, parts) < parts) ++r;
  return r;
}

}  // namespace

// Both sides are made as often as they must, with one place less behind the one that is kept, and one time less before.
std::size_t parts_until_kept(std::size_t parts, std::size_t places) noexcept {
  const std::ptrdiff_t r = most_times(parts, places);
  const auto s = static_cast<std::ptrdiff_t>(places);
  const std::size_t most_before = reached(s, r - 1, parts),
                    least_behind = std::max<std::size_t>(1, reached(s - 1, r - 1, parts));
  return std::clamp<std::size_t>(std::min(most_before, parts - std::min(parts, least_behind)), 1, parts - 1);
}

std::size_t parts_passed(std::size_t parts, std::size_t places) noexcept {
  if (parts < 2) return 0;
  const std::ptrdiff_t r = most_times(parts, places);
  return static_cast<std::size_t>(r) * parts -
         reached(static_cast<std::ptrdiff_t>(places) + 1, r - 1, std::numeric_limits<std::size_t>::max());
}

}  // namespace springnet::learning
