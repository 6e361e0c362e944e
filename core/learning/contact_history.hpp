// Which nodes were in contact in each step of a motion, so that a step can be looked at again, forwards and backwards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <springnet/simulation.hpp>

#include "learning/contact_output.hpp"

namespace springnet::learning {

// By node, the engine's number.
using Touches = std::map<std::uint32_t, Touch>;
[[nodiscard]] Touch touch_of(const Touches& touches, std::uint32_t node);
// The first node whose contact is not the same in both; none: all are.
[[nodiscard]] std::optional<std::uint32_t> differing_node(const Touches& one, const Touches& other);
// Those committed.
[[nodiscard]] Touches contacts_of(const Contact& contact, std::uint32_t nodes);

// Friction keeps the direction of a slip that begins, or ends.
struct Slipping {
  std::uint32_t node;
  Vector3 direction;
  Contact::Slip phase;
};

class ContactHistory {
 public:
  // The contacts of the simulation's present state are those of state 0.
  void begin(const Simulation& simulation);
  // After the step that has reached state `step`.
  void record(const Simulation& simulation, std::size_t step);
  // In place of it, of a step in which contacts stay as they are, and then change: first those within it, which are
  // those with which it begins, too; then changes at its end, node by node.
  void keep(const Simulation& simulation, std::size_t step, const Touches& within);
  void change(std::size_t step, std::uint32_t node, const Touch& after);
  // Slips at a state, if there are any that begin or end.
  void set_slips(std::size_t state, std::vector<Slipping> slips);
  [[nodiscard]] const std::vector<Slipping>& slips_at(std::size_t state) const;

  // The contacts with which the step after a state begins: those committed there, and what a change from outside made
  // of them (ruptures, loads that are switched).
  [[nodiscard]] const Touches& at(std::size_t state);
  // Those within the step that ends at a state.
  [[nodiscard]] std::vector<StepContact> within(std::size_t step);

 private:
  struct Change {
    StepContact contact;
    Touch after;  // committed at the end
  };
  void move_to(std::size_t state);
  void set(std::uint32_t node, const Touch& touch);
  void settle(const Simulation& simulation);

  Touches now_;  // at state_
  std::size_t state_ = 0;
  std::size_t events_ = 0;                              // of the simulation, until the state recorded last
  std::map<std::size_t, std::vector<Change>> changes_;  // by step
  std::map<std::size_t, std::vector<Slipping>> slips_;  // by state
};

}  // namespace springnet::learning
