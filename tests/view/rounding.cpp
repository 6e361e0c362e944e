#include <cmath>

#include <doctest/doctest.h>

#include "view/rounding.hpp"

using namespace springnet::view;

namespace {

// Two nodes 1 m apart that move by less than that; the last of 100 frames as given.
Frames frames_with(float position, float speed, float tension) {
  Frames frames({1, 2, 1, 0}, 100, 100);
  for (int k = 0; k < 100; ++k) {
    const bool last = k == 99;
    frames.begin();
    frames.positions.last()[3] = last ? position : 1.0F + 0.005F * static_cast<float>(k);
    frames.speeds.last()[0] = last ? speed : 0.5F;
    frames.tensions.last()[0] = last ? tension : static_cast<float>(k % 7) - 3.0F;
  }
  return frames;
}

}  // namespace

TEST_CASE("the range of ordinary numbers is theirs, and rounded numbers are within half a step") {
  const Frames frames = frames_with(2.0F, 3.0F, -4.0F);
  const Ranges ranges = ranges_of(frames);
  CHECK(ranges.positions.low == 0.0F);
  CHECK(ranges.positions.high == 2.0F);
  CHECK(ranges.speeds.low == 0.0F);
  CHECK(ranges.speeds.high == 3.0F);
  CHECK(ranges.tensions.low == -4.0F);
  CHECK(ranges.tensions.high == 4.0F);
  CHECK(notes_of(ranges).size() == 1);
  const std::vector<float>& tensions = frames.tensions.numbers();
  const std::vector<std::uint16_t> shares = shares_of(tensions, ranges.tensions);
  constexpr float step = 8.0F / 65535.0F;
  for (std::size_t k = 0; k < tensions.size(); ++k) {
    CHECK(std::abs(-4.0F + static_cast<float>(shares[k]) * step - tensions[k]) <= 0.51F * step);
  }
}

TEST_CASE("the end of a diverging run takes no digits from the rest, with notes") {
  const Frames frames = frames_with(-1e38F, 3e38F, 1e30F);
  const Ranges ranges = ranges_of(frames);
  CHECK(ranges.positions.low == -16.0F);
  CHECK(ranges.positions.high < 1.6F);
  CHECK(ranges.speeds.high == 0.5F);
  CHECK(ranges.tensions.high == 3.0F);
  CHECK(notes_of(ranges).size() == 4);
  CHECK(shares_of(frames.tensions.numbers(), ranges.tensions).back() == 65535);
  CHECK(shares_of(frames.positions.numbers(), ranges.positions)[99 * 6 + 3] == 0);
}

TEST_CASE("large numbers while all nodes are near are no divergence and are kept") {
  const Ranges ranges = ranges_of(frames_with(2.0F, 3e6F, 1e9F));
  CHECK(ranges.speeds.high == 3e6F);
  CHECK(ranges.tensions.high == 1e9F);
  CHECK(notes_of(ranges).size() == 1);
}

TEST_CASE("numbers that are all equal have shares of 0") {
  CHECK(shares_of({2.0F, 2.0F}, {2.0F, 2.0F, false}) == std::vector<std::uint16_t>{0, 0});
}
