// Numbers as 16 bit fractions of a range, for pages that would otherwise become too large.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "view/frames.hpp"

namespace springnet::view {

// A diverging run has numbers beyond the range of float.
[[nodiscard]] float to_float(double number);

struct Range {
  float low = 0.0F, high = 0.0F;
  bool clipped = false;  // there are numbers outside
};

// Ranges of the numbers of all frames. The last frames of a diverging run would leave no digits for the rest: positions
// far from the network's start are clipped, as are speeds and tensions beyond those of the other frames.
struct Ranges {
  Range positions, speeds, tensions;
};
[[nodiscard]] Ranges ranges_of(const Frames& frames);

// 0 for `low` to 65535 for `high`; numbers outside are clipped.
[[nodiscard]] std::vector<std::uint16_t> shares_of(const std::vector<float>& numbers, const Range& range);

// What a reader should know of them, in sentences.
[[nodiscard]] std::vector<std::string> notes_of(const Ranges& ranges);

}  // namespace springnet::view
