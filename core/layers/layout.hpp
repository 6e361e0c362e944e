// The network in memory: units of nodes, tiles of a unit's nodes, segments of a tile's springs with the same laws.
//
// A spring between two nodes of a unit belongs to the tile of its lower node, so that the forces on a tile are final
// once it has been evaluated. A spring between two units is in both, and each adds to its own node only: no two units
// write to the same node, whichever threads they run on, and the order of every sum is fixed by the layout.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "layers/elements/layout.hpp"
#include "layers/kernels.hpp"
#include "layers/laws.hpp"
#include "layers/loaded_faces.hpp"
#include "layers/ordering.hpp"

namespace springnet::layers {

inline constexpr std::uint32_t tile_nodes = 64;
inline constexpr std::uint32_t mixed_rows = 0xffffffffu;

struct Segment {
  std::uint32_t group;
  std::uint32_t row;           // of all its springs, or mixed_rows
  std::uint32_t begin, count;  // slots in the unit
  std::uint32_t run_begin, run_count, run_springs;
  bool boundary;  // springs to other units: force on the first ends only
};

struct Tile {
  std::uint32_t first_node, node_count;
  std::uint32_t segment_begin, segment_end;
};

struct Unit {
  std::uint32_t first_node = 0, node_count = 0;
  std::vector<std::uint32_t> springs;  // with an end in the unit, removed ones included
  std::vector<Tile> tiles;
  std::vector<Segment> segments;
  std::vector<Run> runs;
  // [slot]
  std::vector<std::uint32_t> first, second, row;
};

// A spring seen from one of its ends.
struct Incident {
  std::uint32_t other;  // node
  std::uint32_t group;
  std::uint32_t row;
  std::uint32_t spring;
};

class Layout {
 public:
  Layout(const Network& network, const PluginHost& plugins, bool renumber);
  Layout(const Layout&) = delete;
  Layout& operator=(const Layout&) = delete;

  [[nodiscard]] const Ordering& ordering() const noexcept { return ordering_; }
  [[nodiscard]] const CompiledLaws& laws() const noexcept { return laws_; }
  [[nodiscard]] const ElementLayout& elements() const noexcept { return elements_; }
  [[nodiscard]] const LoadedFaces& loaded_faces() const noexcept { return loaded_faces_; }
  [[nodiscard]] const std::vector<Unit>& units() const noexcept { return units_; }
  [[nodiscard]] std::uint32_t node_count() const noexcept { return static_cast<std::uint32_t>(ordering_.user.size()); }
  [[nodiscard]] std::size_t spring_count() const noexcept { return alive_.size(); }
  [[nodiscard]] std::size_t live_count() const noexcept { return live_count_; }
  // Increases with removals.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }
  [[nodiscard]] bool alive(std::uint32_t spring) const noexcept { return alive_[spring] != 0; }
  // Ends, as the engine numbers nodes.
  [[nodiscard]] std::uint32_t first(std::uint32_t spring) const noexcept { return ends_[2 * spring]; }
  [[nodiscard]] std::uint32_t second(std::uint32_t spring) const noexcept { return ends_[2 * spring + 1]; }
  [[nodiscard]] const Group& group_of(std::uint32_t spring) const noexcept { return laws_.groups[laws_.group[spring]]; }

  // Live springs of a node, sorted by group, then by number.
  [[nodiscard]] const Incident* incident_begin(std::uint32_t node) const noexcept {
    return incident_.data() + incident_start_[node];
  }
  [[nodiscard]] const Incident* incident_end(std::uint32_t node) const noexcept {
    return incident_.data() + incident_stop_[node];
  }
  // Live springs of a group, in rising order.
  [[nodiscard]] const std::vector<std::uint32_t>& springs_of(std::size_t group) const noexcept {
    return springs_of_group_[group];
  }
  // [node] index into laws().neurons.
  [[nodiscard]] const std::vector<std::uint32_t>& neuron_kind() const noexcept { return neuron_kind_; }

  // Neighbours of a node: nodes that it shares a live spring, element, face under a following pressure or rigid
  // connection with, each once, sorted by the user's numbers. Built when first asked for after a removal; not thread
  // safe.
  [[nodiscard]] const std::vector<std::uint32_t>& neighbour_start() const;
  [[nodiscard]] const std::vector<std::uint32_t>& neighbours() const;

  // Remove springs, elements, faces. Those removed before are ignored; returns the others.
  std::vector<std::uint32_t> remove(const std::vector<std::uint32_t>& springs);
  std::vector<std::uint32_t> remove_elements(const std::vector<std::uint32_t>& elements);
  std::vector<std::size_t> remove_faces(const std::vector<std::size_t>& faces);

 private:
  void lay_out(Unit& unit);
  void add_segments(Unit& unit, std::vector<std::uint32_t>& slots, bool boundary);
  void add_segment(Unit& unit, const std::uint32_t* slots, std::size_t count, bool boundary, bool mixed);
  void build_incidence();
  void build_neighbours() const;
  void note_removal() noexcept;
  void build_groups();

  CompiledLaws laws_;
  Ordering ordering_;
  ElementLayout elements_;
  LoadedFaces loaded_faces_;
  std::vector<std::uint32_t> unit_of_;                          // [node]
  std::vector<std::uint32_t> ends_;                             // [2 spring]
  std::vector<std::pair<std::uint32_t, std::uint32_t>> rigid_;  // pairs of nodes in both orders, sorted
  std::vector<std::uint8_t> alive_;
  std::size_t live_count_ = 0;
  std::uint64_t revision_ = 1;
  std::vector<std::uint32_t> neuron_kind_;
  std::vector<Unit> units_;
  std::vector<std::uint64_t> incident_start_, incident_stop_;
  std::vector<Incident> incident_;
  std::vector<std::vector<std::uint32_t>> springs_of_group_;
  mutable std::vector<std::uint32_t> neighbour_start_, neighbours_;  // empty until built
};

}  // namespace springnet::layers
