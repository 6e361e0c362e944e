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
  unsigned turn = 0;               // which is of this segment
  ChunkForces pending{};           // of that before; no springs: none
  const Tile* unsummed = nullptr;  // a tile whose nodes have yet to receive the forces of its chunks
  alignas(64) double changes[6][max_segment];
  Window window{};
  // N, on nodes of the unit and its halo, from its first node on.
  ForceArrays force{};
  ForceRows chunk_force{};  // N, of the chunks of a tile, by their places; the first eight are zeros

  // Memory for all units.
  void reserve(const Layout& layout) {
    std::size_t places = 0, nodes = 0, forces = 0;
    for (const Unit& unit : layout.units()) {
      places = std::max<std::size_t>(places, unit.window);
      nodes = std::max<std::size_t>(nodes, std::size_t{unit.node_count} + unit.halo);
      forces = std::max<std::size_t>(forces, unit.forces);
    }
    if (places > node_state_.size()) {
      node_state_.resize(places);
      node_force_.resize(places);
    }
    // Sums of eight may reach beyond the nodes.
    const ForceRows rows = reserve_rows(nodes + chunk_springs, force_);
    force = {rows.component(0), rows.component(1), rows.component(2)};
    chunk_force = reserve_rows(forces, chunk_force_);
    for (std::size_t c = 0; c < 3; ++c) std::fill_n(chunk_force.component(c), chunk_springs, 0.0);
  }
  void open_window(const Unit& unit) noexcept {
    window = {};
    if (unit.window > 0) window = {&node_state_[0].values, &node_force_[0].values, unit.window - 1};
  }

 private:
  // A cache line, and half of one.
  struct alignas(64) NodeState {
    double values[8];
  };
  struct alignas(32) NodeForce {
    double values[4];
  };
  struct alignas(64) EightForces {
    double values[8];
  };
  // Rows apart by whole pages would compete for the cache.
  static ForceRows reserve_rows(std::size_t count, std::vector<EightForces>& memory) {
    const std::size_t row = (count + 63) / 64 * 8 + 3;
    if (3 * row > memory.size()) memory.assign(3 * row, EightForces{});
    return {memory[0].values, row * chunk_springs};
  }

  std::vector<NodeState> node_state_;
  std::vector<NodeForce> node_force_;
  std::vector<EightForces> force_, chunk_force_;
};

}  // namespace springnet::layers
