// What breaks or is cut in a motion. It is gone from the step after the state at which that happens, and the engine
// that answers for derivatives has to have what a step had, forwards and backwards.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <springnet/simulation.hpp>

#include "simulation/engine.hpp"

namespace springnet::learning {

class Removals {
 public:
  // The engine as it is: at the start.
  explicit Removals(Engine& engine);

  // A new motion; of the events of its simulation so many are from before.
  void begin(std::size_t events);
  // Another engine of the same net that is to follow.
  void follow(Engine& engine) { followers_.push_back(&engine); }
  // Takes the events since, of the step that has reached a state at this time (s). Returns the first of a node that is
  // jammed, or null; contacts are left. of: a later state for some of those at this time; null: none has one.
  const Event* take(const std::vector<Event>& events, std::size_t state, double time,
                    const std::function<std::size_t(const Event&)>& of = nullptr);
  // All so far are of state 0, as of a motion that begins there.
  void begin_at_last();

  [[nodiscard]] bool any_at(std::size_t state) const;
  // The engine as it is in the step that ends at a state; 0: at the start.
  void set_for_step(std::size_t until);

 private:
  Engine& engine_;
  std::vector<Engine*> followers_;
  Topology::Removal at_start_;
  std::vector<Event> events_;        // cuts and ruptures
  std::vector<std::size_t> states_;  // [event], rising
  std::size_t taken_ = 0;            // of the simulation's events
  std::size_t applied_ = 0;          // events that the engine is without
};

}  // namespace springnet::learning
