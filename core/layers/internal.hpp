// The internal state of laws: which elements have it, where it is, and how an evaluation treats it.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/plugin.h>

#include "layers/shared.hpp"

namespace springnet::layers {

struct CompiledLaws;
struct Group;

// Most states of one law.
inline constexpr std::size_t max_states = 8;

// What the elimination of internal states needs later, [internal_count] each.
struct EliminationRecord {
  std::vector<double> force_by_state;           // dQ/dz
  std::vector<double> rate_by_q, rate_by_rate;  // dr/dq, dr/dq'
  std::vector<double> inverse;                  // (I - elimination dr/dz)^-1, rows of max_states
};

// Internal states in an evaluation, in arrays of internal_count numbers (InternalLayout). Without a time step laws have
// those given. With one, these are the states at its start, and laws step them: the nodes of the evaluation are where
// they are at its end.
struct InternalView {
  const double* values = nullptr;
  double time_step = 0.0;   // s
  std::uint32_t order = 1;  // of the step
  // Invariants and rates at the start of the step, in the place of each law's first state; null: not known.
  const double* start_q = nullptr;
  const double* start_rate = nullptr;
  double* next = nullptr;              // out, with a time step: at its end
  double* rates = nullptr;             // out, without one
  double* energy_by_states = nullptr;  // out, with rates: dE/dz of laws that have an energy
  double* start = nullptr;             // out, and nothing else: the states with which laws begin
  // s; above 0, without a time step: derivatives are those with states that follow (springnet_linearisation).
  double elimination = 0.0;
  EliminationRecord* record = nullptr;  // out, with elimination
};

// Where internal states are: group by group, each state of the spring function and of the viscosity function as an
// array over the elements of the group, in the order of the layout.
class InternalLayout {
 public:
  // This bit of a place: the state of that element is read but not written here. Another member has the same element,
  // or the slot has none.
  static constexpr std::uint32_t silent = 0x80000000u;
  struct OfGroup {
    std::uint64_t first = 0;  // in the internal state
    std::uint32_t count = 0;  // elements; 0: its laws have no internal state
  };

  InternalLayout() = default;
  // spring_order: all springs in the order in which they are evaluated; a spring may come again.
  InternalLayout(const CompiledLaws& laws, const std::vector<std::uint32_t>& spring_order, std::size_t spring_count,
                 std::size_t element_count);

  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] bool any() const noexcept { return count_ > 0; }
  [[nodiscard]] bool has(std::size_t group) const noexcept { return any() && groups_[group].count > 0; }
  [[nodiscard]] const OfGroup& group(std::size_t group) const noexcept { return groups_[group]; }
  // Place of a spring, or element, of a group that has internal state.
  [[nodiscard]] std::uint32_t of_spring(std::uint32_t spring) const noexcept { return spring_place_[spring]; }
  [[nodiscard]] std::uint32_t of_element(std::uint32_t element) const noexcept { return element_place_[element]; }
  // For a group whose springs and elements are from another one, and keep their places.
  void add_group_like(std::size_t group) {
    if (any()) groups_.push_back(OfGroup(groups_[group]));
  }
  void drop_groups_from(std::size_t count) {
    if (groups_.size() > count) groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(count), groups_.end());
  }
  // Whether a step of this order needs the invariants at its start.
  [[nodiscard]] bool reads_start(std::uint32_t order) const noexcept { return order >= 2 || own_updates_; }

  // One for each state of each law of a group.
  [[nodiscard]] const std::vector<springnet_internal_range>& ranges() const noexcept { return ranges_; }

 private:
  std::vector<OfGroup> groups_;
  SharedVector<std::uint32_t> spring_place_, element_place_;
  std::vector<springnet_internal_range> ranges_;
  std::uint64_t count_ = 0;
  bool own_updates_ = false;
};

}  // namespace springnet::layers
