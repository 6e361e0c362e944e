// All that a profiler has recorded: a lane for each thread, and the trace.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "profile/lane.hpp"

namespace springnet::profile {

// Events of the beginning and of the end; those between are dropped, whole steps at a time.
class Trace {
 public:
  explicit Trace(std::size_t capacity) : half_(capacity / 2) {}

  [[nodiscard]] std::size_t half() const noexcept { return half_; }
  // Those of a step.
  void add(const std::vector<TraceEvent>& step);
  void clear();
  [[nodiscard]] const std::vector<TraceEvent>& first() const noexcept { return first_; }
  [[nodiscard]] const std::deque<TraceEvent>& last() const noexcept { return last_; }

  std::uint64_t dropped = 0;  // events

 private:
  std::size_t half_;
  std::vector<TraceEvent> first_;
  bool first_is_full_ = false;
  std::deque<TraceEvent> last_;
  std::deque<std::size_t> last_steps_;  // events in each
};

// What a part of a tile takes without content: by its own clock, and of the part around it.
struct PartCost {
  Nanoseconds inside = 0, outside = 0;
};

[[nodiscard]] const PartCost& measured_part_cost();

class Recording {
 public:
  Recording(std::size_t trace_events, const PartCost& part_cost);

  // The lane of the thread that has the scopes; the others help it.
  [[nodiscard]] Lane& first() noexcept { return *lanes_.front(); }
  [[nodiscard]] Lane& lane(std::uint32_t thread) noexcept { return *lanes_[thread]; }
  [[nodiscard]] const std::vector<std::unique_ptr<Lane>>& lanes() const noexcept { return lanes_; }
  // Makes lanes for threads 0 to count - 1. Returns false if memory runs out.
  bool prepare(std::uint32_t count) noexcept;
  // Moves the events of all lanes to the trace.
  void collect() noexcept;
  [[nodiscard]] const Trace& trace() const noexcept { return trace_; }
  [[nodiscard]] bool traces() const noexcept { return trace_.half() > 0; }
  [[nodiscard]] const PartCost& part_cost() const noexcept { return part_cost_; }
  // What the times of the trace count from.
  [[nodiscard]] Nanoseconds origin() const noexcept { return origin_; }
  void clear();

  // Profile of everything recorded: merge.cpp.
  [[nodiscard]] Profile merged() const;

  std::atomic<bool> in_use{false};  // a thread has a scope open

 private:
  std::vector<std::unique_ptr<Lane>> lanes_;
  Trace trace_;
  std::vector<TraceEvent> step_;  // memory of collect()
  PartCost part_cost_;
  Nanoseconds origin_;
};

}  // namespace springnet::profile
