// Which nodes were in contact in each step of a motion, so that a step can be looked at again, forwards and backwards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include <springnet/simulation.hpp>

#include "learning/contact_output.hpp"

namespace springnet::learning {

class ContactHistory {
 public:
  // The contacts of the simulation's present state are those of state 0.
  void begin(const Simulation& simulation);
  // After the step that has reached state `step`.
  void record(const Simulation& simulation, std::size_t step);

  // The contacts with which the step after a state begins, by node (the engine's number): those committed there, and
  // what a change from outside made of them (ruptures, loads that are switched).
  [[nodiscard]] const std::map<std::uint32_t, Touch>& at(std::size_t state);
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

  std::map<std::uint32_t, Touch> now_;  // at state_
  std::size_t state_ = 0;
  std::size_t events_ = 0;                              // of the simulation, until the state recorded last
  std::map<std::size_t, std::vector<Change>> changes_;  // by step
};

}  // namespace springnet::learning
