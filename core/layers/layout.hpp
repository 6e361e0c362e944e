// The network in memory: units of nodes with their springs (unit.hpp), springs by their nodes and by their laws.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "layers/elements/layout.hpp"
#include "layers/laws.hpp"
#include "layers/loaded_faces.hpp"
#include "layers/ordering.hpp"
#include "layers/shared.hpp"
#include "layers/unit.hpp"

namespace springnet::layers {

// A spring seen from one of its ends.
struct Incident {
  std::uint32_t other;  // node
  std::uint32_t group;
  std::uint32_t row;
  std::uint32_t spring;
};

class Layout {
 public:
  // threads: that lay out units; 0: as many as the machine has.
  Layout(const Network& network, const PluginHost& plugins, bool renumber, unsigned threads = 0);
  // A copy, which may be changed and used by another thread. The two share what neither changes.
  Layout(const Layout& other);
  Layout& operator=(const Layout&) = delete;

  [[nodiscard]] const Ordering& ordering() const noexcept { return *ordering_; }
  [[nodiscard]] const CompiledLaws& laws() const noexcept { return laws_; }
  // Set by who simulates the network, between evaluations.
  [[nodiscard]] Signals& signals() noexcept { return *laws_.signals; }
  [[nodiscard]] const ElementLayout& elements() const noexcept { return elements_; }
  [[nodiscard]] const LoadedFaces& loaded_faces() const noexcept { return loaded_faces_; }
  [[nodiscard]] const InternalLayout& internal() const noexcept { return internal_; }
  [[nodiscard]] const std::vector<Unit>& units() const noexcept { return units_; }
  [[nodiscard]] std::uint32_t node_count() const noexcept { return static_cast<std::uint32_t>(ordering_->user.size()); }
  [[nodiscard]] std::size_t spring_count() const noexcept { return alive_.size(); }
  [[nodiscard]] std::size_t live_count() const noexcept { return live_count_; }
  // Increases with removals.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }
  [[nodiscard]] bool alive(std::uint32_t spring) const noexcept { return alive_[spring] != 0; }
  // Ends, as the engine numbers nodes.
  [[nodiscard]] std::uint32_t first(std::uint32_t spring) const noexcept { return ends_[2 * spring]; }
  [[nodiscard]] std::uint32_t second(std::uint32_t spring) const noexcept { return ends_[2 * spring + 1]; }
  [[nodiscard]] const Group& group_of(std::uint32_t spring) const noexcept { return laws_.groups[laws_.group[spring]]; }

  // Live springs of a node, sorted by group, then by number. Built when first asked for, by any thread; before threads
  // ask that must not throw, call need_incidence(), which throws std::bad_alloc.
  void need_incidence() const {
    if (!found_->has_incidence.load(std::memory_order_acquire)) build_incidence();
  }
  [[nodiscard]] const Incident* incident_begin(std::uint32_t node) const {
    need_incidence();
    return found_->incident.data() + found_->incident_start[node];
  }
  [[nodiscard]] const Incident* incident_end(std::uint32_t node) const {
    need_incidence();
    return found_->incident.data() + found_->incident_stop[node];
  }
  // Live springs of a group, in rising order. Built when first asked for after a removal.
  [[nodiscard]] const std::vector<std::uint32_t>& springs_of(std::size_t group) const;
  // The unit of a node.
  [[nodiscard]] std::uint32_t unit_of(std::uint32_t node) const noexcept;
  // [node] index into laws().neurons.
  [[nodiscard]] const std::vector<std::uint32_t>& neuron_kind() const noexcept { return neuron_kind_.get(); }

  // Neighbours of a node: nodes that it shares a live spring, element, face under a following pressure or rigid
  // connection with, each once, sorted by the user's numbers. Built when first asked for after a removal.
  [[nodiscard]] const std::vector<std::uint32_t>& neighbour_start() const;
  [[nodiscard]] const std::vector<std::uint32_t>& neighbours() const;
  [[nodiscard]] bool has_neighbours() const noexcept { return found_->has_neighbours.load(std::memory_order_acquire); }

  // Remove springs, elements, faces. Those removed before are ignored; returns the others.
  std::vector<std::uint32_t> remove(const std::vector<std::uint32_t>& springs);
  std::vector<std::uint32_t> remove_elements(const std::vector<std::uint32_t>& elements);
  std::vector<std::size_t> remove_faces(const std::vector<std::size_t>& faces);
  // All that were removed are there again, as at the start.
  void put_back_all();

 private:
  // To the units that have a spring: what(unit, the spring as it is seen from there).
  template <class What>
  void for_units_of(std::uint32_t spring, const What& what) const;
  void lay_out(unsigned threads);
  void lay_out_again(Unit& unit);
  void place_internal(Unit& unit) const;
  void build_incidence() const;
  void build_neighbours() const;
  void build_springs() const;
  void note_removal();

  // What is found when first asked for. Copies find it once; a removal in one of them begins anew.
  struct Found {
    mutable std::mutex building;
    mutable std::atomic<bool> has_incidence{false}, has_neighbours{false}, has_springs{false};
    mutable std::vector<std::uint64_t> incident_start, incident_stop;
    mutable std::vector<Incident> incident;
    mutable std::vector<std::vector<std::uint32_t>> springs_of_group;
    mutable std::vector<std::uint32_t> neighbour_start, neighbours;
  };

  CompiledLaws laws_;
  Shared<Ordering> ordering_;
  ElementLayout elements_;
  LoadedFaces loaded_faces_;
  InternalLayout internal_;
  SharedVector<std::uint32_t> ends_;                             // [2 spring]
  SharedVector<std::pair<std::uint32_t, std::uint32_t>> rigid_;  // pairs of nodes in both orders, sorted
  SharedVector<std::uint8_t> alive_;
  std::size_t live_count_ = 0;
  std::uint64_t revision_ = 1;
  SharedVector<std::uint32_t> neuron_kind_;
  std::vector<Unit> units_;
  Shared<Found> found_;
};

}  // namespace springnet::layers
