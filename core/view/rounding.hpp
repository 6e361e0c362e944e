// Numbers as 16 bit shares of a range, where a page would become too large otherwise.
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

// Ranges for the numbers of all frames. A run that diverges ends in numbers that would leave no digits to the rest:
// places far away from where the network began are outside, and what the frames with such places alone reach in speed
// and tension.
struct Ranges {
  Range positions, speeds, tensions;
};
[[nodiscard]] Ranges ranges_of(const Frames& frames);

// 0 for `low` to 65535 for `high`; the nearest of these for numbers outside.
[[nodiscard]] std::vector<std::uint16_t> shares_of(const std::vector<float>& numbers, const Range& range);

// What a reader has to know of them, in plain sentences.
[[nodiscard]] std::vector<std::string> notes_of(const Ranges& ranges);

}  // namespace springnet::view
