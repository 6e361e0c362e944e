#include "view/frames.hpp"

#include <algorithm>

namespace springnet::view {

Frames::Frames(const FrameWidths& widths, std::size_t capacity, std::size_t expected)
    : scalars(widths.scalars, std::min(capacity, expected) + 1),
      positions(3 * widths.nodes, std::min(capacity, expected) + 1),
      start_positions(3 * widths.start_nodes, std::min(capacity, expected) + 1),
      speeds(widths.nodes, std::min(capacity, expected) + 1),
      tensions(widths.springs, std::min(capacity, expected) + 1),
      surfaces(surface_numbers * widths.surfaces, std::min(capacity, expected) + 1),
      resultants(3 * widths.loads, std::min(capacity, expected) + 1),
      forces(3 * widths.arrows, std::min(capacity, expected) + 1),
      touches(touch_numbers * widths.touches, std::min(capacity, expected) + 1),
      states(widths.states, std::min(capacity, expected) + 1),
      contact((widths.nodes + 7) / 8, std::min(capacity, expected) + 1),
      capacity_(std::max<std::size_t>(capacity, 2)) {}

void Frames::archive(Archive& archive) {
  archive.number(stride_);
  archive.number(recorded_);
  std::size_t count = count_;
  archive.below(count, capacity_ + 1, "a frame of the page");
  if (stride_ == 0) Archive::refuse("the stride of frames is 0");
  count_ = 0;  // until all rows are there
  each([&](auto& rows) { rows.archive(archive, count); });
  count_ = count;
}

void Frames::begin() {
  // The latest record stands in for the last one until another comes.
  if (count_ > 0 && (recorded_ - 1) % stride_ != 0) {
    each([](auto& rows) { rows.pop(); });
    --count_;
  }
  while (count_ + 1 > capacity_) halve();
  each([](auto& rows) { rows.append(); });
  ++count_;
  ++recorded_;
}

void Frames::halve() {
  const std::size_t kept = (count_ + 1) / 2;
  each([&](auto& rows) {
    for (std::size_t k = 1; k < kept; ++k) rows.copy(2 * k, k);
    rows.shrink(kept);
  });
  count_ = kept;
  stride_ *= 2;
}

}  // namespace springnet::view
