#include "view/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

namespace springnet::view {

namespace {

Range range_of(std::span<const float> numbers) {
  if (numbers.empty()) return {};
  const auto [low, high] = std::minmax_element(numbers.begin(), numbers.end());
  return {*low, *high, false};
}

// Of positions: at most 16 sizes of the network from its start.
Range position_range(const Frames& frames) {
  constexpr float max_sizes = 16.0F;
  const std::vector<float>& all = frames.positions.numbers();
  Range range = range_of(all);
  if (!frames.start_positions.numbers().empty()) {
    const Range other = range_of(frames.start_positions.numbers());
    range = {std::min(range.low, other.low), std::max(range.high, other.high), false};
  }
  const Range start = range_of(std::span(all).first(all.size() / std::max<std::size_t>(frames.count(), 1)));
  const float size = start.high - start.low;
  if (!(size > 0.0F)) return range;
  const float low = start.low - max_sizes * size, high = start.high + max_sizes * size;
  return {std::max(range.low, low), std::min(range.high, high), range.low < low || range.high > high};
}

// Of a frame's row, `width` numbers in each.
std::span<const float> row(const std::vector<float>& numbers, std::size_t frame, std::size_t frames) {
  const std::size_t width = numbers.size() / frames;
  return std::span(numbers).subspan(frame * width, width);
}

// Symmetric. Taken from the frames with all nodes within the range of positions, or from all frames if there is none.
Range symmetric_range(const std::vector<float>& numbers, const Frames& frames, const Range& positions) {
  float largest = 0.0F, bound = 0.0F;
  for (std::size_t k = 0; k < frames.count(); ++k) {
    const Range position = range_of(row(frames.positions.numbers(), k, frames.count()));
    const Range value = range_of(row(numbers, k, frames.count()));
    const float max = std::max(-value.low, value.high);
    largest = std::max(largest, max);
    if (position.low >= positions.low && position.high <= positions.high) bound = std::max(bound, max);
  }
  if (!(bound > 0.0F)) bound = largest;
  return {-bound, bound, largest > bound};
}

}  // namespace

float to_float(double number) {
  constexpr double max = std::numeric_limits<float>::max();
  return static_cast<float>(std::clamp(number, -max, max));
}

Ranges ranges_of(const Frames& frames) {
  Ranges ranges;
  ranges.positions = position_range(frames);
  ranges.speeds = symmetric_range(frames.speeds.numbers(), frames, ranges.positions);
  ranges.tensions = symmetric_range(frames.tensions.numbers(), frames, ranges.positions);
  ranges.speeds.low = 0.0F;
  return ranges;
}

std::vector<std::uint16_t> shares_of(const std::vector<float>& numbers, const Range& range) {
  std::vector<std::uint16_t> shares(numbers.size());
  const float scale = range.high > range.low ? 65535.0F / (range.high - range.low) : 0.0F;
  std::transform(numbers.begin(), numbers.end(), shares.begin(), [&](float number) {
    return static_cast<std::uint16_t>(std::lround((std::clamp(number, range.low, range.high) - range.low) * scale));
  });
  return shares;
}

std::vector<std::string> notes_of(const Ranges& ranges) {
  std::vector<std::string> notes{
      "positions, speeds and tensions are rounded to 16 bits of their range, so that more records fit; a larger "
      "output.view_size keeps more digits"};
  if (ranges.positions.clipped) {
    notes.push_back(fmt::format("coordinates outside {:.3g} m to {:.3g} m are shown at these bounds",
                                ranges.positions.low, ranges.positions.high));
  }
  if (ranges.speeds.clipped)
    notes.push_back(fmt::format("speeds above {0:.3g} m/s are shown as {0:.3g} m/s", ranges.speeds.high));
  if (ranges.tensions.clipped) {
    notes.push_back(fmt::format("tensions beyond {0:.3g} N are shown as {0:.3g} N", ranges.tensions.high));
  }
  return notes;
}

}  // namespace springnet::view
