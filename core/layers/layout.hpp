// The network in memory: units of nodes with their springs (unit.hpp), springs by their nodes and by their laws.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

#include "layers/elements/layout.hpp"
#include "layers/laws.hpp"
#include "layers/loaded_faces.hpp"
#include "layers/numbers_before.hpp"
#include "layers/ordering.hpp"
#include "layers/shared.hpp"
#include "layers/unit.hpp"
#include "text/archive.hpp"

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
  [[nodiscard]] const Signals& signals() const noexcept { return *laws_.signals; }
  [[nodiscard]] const ElementLayout& elements() const noexcept { return elements_; }
  [[nodiscard]] const LoadedFaces& loaded_faces() const noexcept { return loaded_faces_; }
  [[nodiscard]] const InternalLayout& internal() const noexcept { return internal_; }
  [[nodiscard]] const std::vector<Unit>& units() const noexcept { return units_; }
  [[nodiscard]] std::uint32_t node_count() const noexcept { return static_cast<std::uint32_t>(ordering_->user.size()); }
  [[nodiscard]] std::size_t spring_count() const noexcept { return alive_.size(); }
  [[nodiscard]] std::size_t live_count() const noexcept { return live_count_; }
  // Increases with removals, and where units are laid out anew.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }
  // Increases with changes of laws' parameters, rest lengths, inputs and neurons.
  [[nodiscard]] std::uint64_t value_revision() const noexcept { return value_revision_; }
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
  // Whether springs lie as if all that have been removed had been removed at once.
  [[nodiscard]] bool is_as_removed_at_once() const noexcept;

  // Changes of the values that laws and neurons read (layout_changes.cpp); settle_changes() must follow, and whoever
  // keeps something that depends on them must be told.
  struct ValueChange {
    std::size_t column = 0;  // of the group: 0 the rest length or reference, Law::first_column + k a parameter, …
    double value = 0.0;
    // Of the law whose parameter it is, if that prepares something: [0 spring function, 1 viscosity function], and what
    // it prepared of the new parameters (prepare()).
    std::size_t law = 0;
    std::shared_ptr<const Prepared> prepared{};
  };
  void set_spring_value(std::uint32_t spring, const ValueChange& change);
  void set_element_value(std::uint32_t element, const ValueChange& change);
  // Inputs of a spring's or element's law no longer follow their signal.
  void set_spring_input(std::uint32_t spring, std::size_t column, double value);
  void set_element_input(std::uint32_t element, std::size_t column, double value);
  void set_neuron_parameter(std::span<const std::uint32_t> nodes, std::size_t parameter,
                            std::span<const double> values);
  void settle_changes();
  // What a law prepares of the parameters of a row, but for the one that changes; null if it prepares nothing. Throws
  // Error(input) if it refuses them.
  [[nodiscard]] std::shared_ptr<const Prepared> prepare(const Group& group, std::uint32_t row,
                                                        const ValueChange& change);
  // What has been changed, with the values as they are now. Returns whether units are to be laid out (put_back_all).
  [[nodiscard]] bool archive_changes(Archive& archive);
  // Changes and removals in the layout of the network before it was extended.
  void take_over(const Layout& before, const NumbersBefore& numbers);
  [[nodiscard]] bool has_changes() const noexcept { return original_ != nullptr; }
  // Groups, and group and row of a spring, before any change.
  [[nodiscard]] std::size_t first_group_count() const noexcept {
    return original_ ? original_->groups : laws_.groups.size();
  }
  [[nodiscard]] std::uint32_t first_group(std::uint32_t spring) const {
    return original_ ? original_->group[spring] : laws_.group[spring];
  }
  [[nodiscard]] std::uint32_t first_row(std::uint32_t spring) const {
    return original_ ? original_->row[spring] : laws_.row[spring];
  }

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
  // As it was before the first change.
  struct Original {
    SharedColumn<std::uint32_t> group;
    RowNumbers row;
    SharedColumn<std::uint32_t> element_group, element_row;
    SharedVector<std::uint32_t> neuron_kind;
    std::size_t groups = 0, neurons = 0, signals = 0;
  };
  struct ChangedRow;
  void remember_original();
  void take_back_changes();
  std::uint32_t add_row(std::uint32_t to_group, std::uint32_t from_group, std::uint32_t row);
  std::uint32_t variant_of(std::uint32_t group, const ValueChange& change);
  [[nodiscard]] std::uint64_t internal_of(std::size_t group) const noexcept;
  void count_variants(std::uint32_t from, std::uint32_t to) noexcept;
  void write_value(std::uint32_t unit, std::uint32_t own, std::uint32_t spring, const ValueChange& change);
  void update_incidence(std::uint32_t spring);
  void forget_springs_of_groups();
  void take_over_row(const Layout& before, std::uint32_t member, bool is_element);
  void archive_row(Archive& archive, ChangedRow& changed, std::uint32_t first_group) const;
  void take_up_row(const ChangedRow& changed, bool of_element);
  [[nodiscard]] bool is_private(double signal) const noexcept;

  CompiledLaws laws_;
  Shared<Ordering> ordering_;
  ElementLayout elements_;
  LoadedFaces loaded_faces_;
  InternalLayout internal_;
  SharedVector<std::uint32_t> ends_;                             // [2 spring]
  SharedVector<std::pair<std::uint32_t, std::uint32_t>> rigid_;  // pairs of nodes in both orders, sorted
  SharedVector<std::uint8_t> alive_;
  std::size_t live_count_ = 0;
  std::uint64_t revision_ = 1, value_revision_ = 0;
  std::unique_ptr<Original> original_;        // null: nothing has been changed
  PreparedTables prepared_;                   // of changed parameters
  std::vector<std::uint32_t> variant_users_;  // [group after those at first] springs and elements
  std::vector<std::uint32_t> neuron_users_;   // [index into laws_.neurons]; empty: no neuron has been changed
  std::vector<std::uint32_t> free_neurons_;   // of these, added ones that no node has
  std::vector<std::uint32_t> units_due_;      // to be laid out again
  bool elements_due_ = false, all_due_ = false;
  SharedVector<std::uint32_t> neuron_kind_;
  std::vector<Unit> units_;
  Shared<Found> found_;
};

}  // namespace springnet::layers
