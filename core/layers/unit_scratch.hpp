// What a thread needs to evaluate a unit.
#pragma once

#include <algorithm>
#include <vector>

#include "layers/layout.hpp"

namespace springnet::layers {

struct UnitScratch {
  SegmentGeometry geometry;  // not initialised: written before it is read
  alignas(64) double changes[6][max_segment];
  Window window{};

  // Memory for the windows of all units.
  void reserve(const Layout& layout) {
    std::size_t places = 0;
    for (const Unit& unit : layout.units()) places = std::max<std::size_t>(places, unit.window);
    if (places > state_.size()) {
      state_.resize(places);
      force_.resize(places);
    }
  }
  void open_window(const Unit& unit) noexcept {
    window = {&state_.data()->values, &force_.data()->values, unit.window == 0 ? 0 : unit.window - 1};
  }

 private:
  // A cache line, and half of one.
  struct alignas(64) NodeState {
    double values[8];
  };
  struct alignas(32) NodeForce {
    double values[4];
  };
  std::vector<NodeState> state_;
  std::vector<NodeForce> force_;
};

}  // namespace springnet::layers
