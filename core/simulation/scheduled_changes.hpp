// The scene's changes of laws, neurons, rest states and masses, at the first moment of their time, as cuts.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <springnet/network.hpp>

#include "text/archive.hpp"

namespace springnet {

class Engine;

class ScheduledChanges {
 public:
  // Throws Error(input) for names that laws do not have, and values out of their bounds.
  ScheduledChanges(Engine& engine, const std::vector<Change>& changes);

  // Those up to the committed time, but for exchanges of the integrator.
  void perform_due();
  // Whether a change at a time (s) is made at the end of a step that reaches `now`: but for rounding of times.
  [[nodiscard]] static bool is_due(double time, double now, double time_step) noexcept;
  // Sets what a change of the scene, by its number, says of laws, rest states, neurons and masses, and leaves what it
  // removes; it does not count as made.
  void set_values_of(std::size_t change) { set_values_of(changes_[change].change); }
  // Numbers of the changes in the order in which they are made.
  [[nodiscard]] const std::vector<std::size_t>& in_order() const noexcept { return by_time_; }
  // Time of the next change, s; infinity if there is none.
  [[nodiscard]] double next(double time) const noexcept;
  // Of a change of the scene, by its number: whether it was made, and its integrator exchanged.
  [[nodiscard]] bool is_done(std::size_t change) const { return changes_[change].done; }
  [[nodiscard]] bool is_exchanged(std::size_t change) const { return changes_[change].exchanged; }
  // The next exchange of the integrator that has not been made: its time, s; infinity if there is none.
  [[nodiscard]] double next_exchange() const noexcept;
  // The integrator of that; it counts as made then.
  [[nodiscard]] LawUse take_exchange();
  // Those that were made.
  void archive(Archive& archive);
  // The same of the network before it was extended.
  void take_over(const ScheduledChanges& before);

 private:
  struct Scheduled {
    Change change;
    bool done = false, exchanged = false;
  };
  void check(const Change& change) const;
  void perform(const Change& change);
  void set_values_of(const Change& change);
  [[nodiscard]] std::vector<Scheduled>::iterator first_exchange() noexcept;

  Engine& engine_;
  std::vector<Scheduled> changes_;
  std::vector<std::size_t> by_time_;  // places in changes_
};

}  // namespace springnet
