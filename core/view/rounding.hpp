// Numbers as 16 bit fractions of a range, for pages that would become too large otherwise.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "view/frames.hpp"

namespace springnet::view {

struct Range {
  float low = 0.0F, high = 0.0F;
  bool clipped = false;  // there are numbers outside of it
};

// Ranges for the numbers of all frames. The last numbers of a diverging run would leave no digits for the rest, so
// places far from the start of the network are outside of the range, as are speeds and tensions that only such frames
// have.
struct Ranges {
  Range positions, speeds, tensions;
};
[[nodiscard]] Ranges ranges_of(const Frames& frames);

// 0 for `low` to 65535 for `high`; the nearest of these for numbers outside.
[[nodiscard]] std::vector<std::uint16_t> shares_of(const std::vector<float>& numbers, const Range& range);

// What a reader should know of them, in sentences.
[[nodiscard]] std::vector<std::string> notes_of(const Ranges& ranges);

}  // namespace springnet::view
