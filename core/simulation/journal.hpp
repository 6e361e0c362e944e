// What a run reports besides its motion: events, notes, numbers, and reasons of failures.
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/simulation.hpp>

#include "layers/numbers_before.hpp"
#include "text/archive.hpp"

namespace springnet {

// Any thread of a sweep may call note(), report() and count(); events belong to the thread of the integrator.
class Journal {
 public:
  // Guards the two texts below, as several threads may fail.
  std::mutex failure_lock;
  // Why the last host function failed; integrators read and write it.
  springnet_message message{};
  // Why numbers are not finite, or could not be evaluated, in the present step; empty: they are finite.
  std::string non_finite;

  // The same of the network before it was extended.
  void take_over(const Journal& before, const layers::NumbersBefore& numbers);
  // Events, notes and numbers.
  void archive(Archive& archive);
  void record(const Event& event) { events_.push_back(event); }
  // Those recorded after the first ones, `count` in number.
  void forget_events(std::size_t count) { events_.resize(std::min(count, events_.size())); }
  // Notes are kept once each, and the first one on a topic (empty: none). Beyond a few hundred, notes and numbers are
  // dropped: an integrator that reports something new in every step must not fill the memory.
  void note(const std::string& text, const std::string& topic = {});
  void report(const std::string& name, double value);
  // Adds to a number and returns it.
  double count(const std::string& name, double more = 1.0);

  [[nodiscard]] const std::vector<Event>& events() const noexcept { return events_; }
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
  [[nodiscard]] const std::map<std::string, double>& numbers() const noexcept { return numbers_; }

 private:
  void set_number(const std::string& name, double value);

  std::mutex lock_;
  std::vector<Event> events_;
  std::vector<std::string> notes_, topics_;
  std::map<std::string, double> numbers_;
};

}  // namespace springnet
