// What a thread needs to evaluate a unit.
#pragma once

#include <algorithm>
#include <vector>

#include "layers/layout.hpp"

namespace springnet::layers {

struct UnitScratch {
  // Of a segment, and of the one before, whose forces may have yet to reach the nodes. Not initialised: written before
  // they are read.
  struct Springs {
    SegmentGeometry geometry;
    alignas(64) double force[2][max_segment];  // [law] N
  };
  Springs springs[2];
  unsigned turn = 0;      // which is of this segment
  ChunkForces pending{};  // of that before; no springs: none
  alignas(64) double changes[6][max_segment];
  Window window{};
  // N, on nodes of the unit and its halo, from its first node on.
  ForceArrays force{};

  // Memory for all units.
  void reserve(const Layout& layout) {
    std::size_t places = 0, nodes = 0;
    for (const Unit& unit : layout.units()) {
      places = std::max<std::size_t>(places, unit.window);
      nodes = std::max<std::size_t>(nodes, std::size_t{unit.node_count} + unit.halo);
    }
    if (places > node_state_.size()) {
      node_state_.resize(places);
      node_force_.resize(places);
    }
    // Slots of chunks without a spring may lie outside; rows apart by whole pages would compete for the cache.
    const std::size_t row = (nodes + 2 * chunk_springs + 63) / 64 * 64 + 24;
    if (3 * row > force_.size()) force_.assign(3 * row, 0.0);
    double* const first = force_.data() + chunk_springs;
    force = {first, first + row, first + 2 * row};
  }
  void open_window(const Unit& unit) noexcept {
    window = {&node_state_.data()->values, &node_force_.data()->values, unit.window == 0 ? 0 : unit.window - 1};
  }

 private:
  // A cache line, and half of one.
  struct alignas(64) NodeState {
    double values[8];
  };
  struct alignas(32) NodeForce {
    double values[4];
  };
  std::vector<NodeState> node_state_;
  std::vector<NodeForce> node_force_;
  std::vector<double> force_;
};

}  // namespace springnet::layers
