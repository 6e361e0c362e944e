// The scene's changes of laws, rest states, neurons and masses in a motion: from the step after its state on a net has
// what a change gives it, and the engines that answer for derivatives have to have what a step had, forwards and
// backwards. What changes remove is left to Removals.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "learning/learned_values.hpp"
#include "simulation/engine.hpp"

namespace springnet::learning {

class SceneChanges {
 public:
  // An engine with the values at the start; and `learned` is told of the changes that have been made. Throws
  // Error(input) for changes that are not differentiated.
  SceneChanges(const Network& network, Engine& engine, LearnedSets& learned);
  // Another engine of the same net that is to follow, with the same values.
  void follow(Engine& engine) { engines_.push_back(&engine); }

  // A new motion. The engines have what the network says, and what is learned is to be set.
  void begin();
  // After the step that has reached a state at this time (s).
  void take(std::size_t state, double time);
  // All so far are of state 0, as of a motion that begins there.
  void begin_at_last();
  // The engines as they are in the step that ends at a state; 0: at the start. Costs in proportion to what the changes
  // between the present step and that one concern.
  void set_for_step(std::size_t until);
  // At most, of the values that changes have replaced.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] bool any_at(std::size_t state) const;

 private:
  using PutBack = std::vector<std::function<void(Engine&)>>;
  // What the engines have that a change is to replace.
  [[nodiscard]] PutBack values_before(const Change& change) const;
  void make_next();
  void undo_last();

  const std::vector<Change>& changes_;
  LearnedSets& learned_;
  std::vector<std::size_t> order_;   // numbers of changes to come, in the order in which they are made
  std::vector<std::size_t> states_;  // [change made], rising
  std::vector<Engine*> engines_;
  std::vector<PutBack> made_;  // [change made]
};

}  // namespace springnet::learning
