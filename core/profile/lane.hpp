// What one thread records: a tree of stages with the time in each, and the course of those that have ended.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <springnet/profile.hpp>

namespace springnet::profile {

using Kind = ProfileStage::Kind;
using Nanoseconds = std::int64_t;

// Of a clock that never goes back.
[[nodiscard]] inline Nanoseconds now() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

constexpr std::uint32_t none = 0xffffffffu;

struct Node {
  std::string name;
  Kind kind = Kind::stage;
  bool estimated = false;  // calls and time are those of measured tiles, by their weight
  bool region = false;     // a parallel region; its parts are those of the stage it is in
  std::uint32_t parent = none, first_child = none, next = none;  // next: child of the same parent
  // Work of one thread in a parallel region that this many share; 0: anything else.
  std::uint32_t team = 0;
  std::uint32_t of_region = none;  // for that: the region, a node of the first lane
  std::uint64_t calls = 0;
  Nanoseconds time = 0;
  Nanoseconds started = 0;  // of the present call, if it is open
  // Of the tiles in this stage: so many more are measured each, then one in `sampling` on average.
  std::uint32_t measure_all = first_tiles;
  std::uint32_t skip = 0;  // and so many are not before the next is

  static constexpr std::uint32_t first_tiles = 64;
  static constexpr std::uint32_t sampling = 256;
};

// A stage that has ended, for the trace.
struct TraceEvent {
  std::uint32_t node;    // of the first lane
  std::uint32_t thread;  // number of the lane
  Nanoseconds begin, end;
};

class Recording;

class Lane {
 public:
  Lane(Recording& recording, std::uint32_t number) : recording_(recording), number_(number) { clear(); }

  // Begins a part of the present stage, or ends the present stage. Memory may run out: then nothing begins, the answer
  // is false, and the time belongs to the stage around it.
  bool begin(Kind kind, const char* name) noexcept { return enter({name, kind, false, none, 0}, now()); }
  void end() noexcept;
  // The same for a parallel region, and for this thread's share of the work in one.
  bool begin_region() noexcept { return enter({"", Kind::stage, true, none, 0}, now()); }
  void end_region() noexcept { leave(now()); }
  bool begin_share(std::uint32_t region, std::uint32_t team) noexcept {
    return enter({"", Kind::stage, false, region, team}, now());
  }
  void end_share(std::uint32_t stage) noexcept;

  // Whether to measure the next tile of this stage. Parts of a measured tile count as often as there are tiles to one
  // that is measured, and what the clock takes is not in their time.
  bool measures_next() noexcept {
    Node& stage = nodes_[present_];
    if (stage.skip == 0) return measure(stage);
    --stage.skip;
    return false;
  }
  bool begin_part(Kind kind, const char* name) noexcept;
  void end_part() noexcept;

  [[nodiscard]] Recording& recording() const noexcept { return recording_; }
  [[nodiscard]] std::uint32_t number() const noexcept { return number_; }
  [[nodiscard]] const std::vector<Node>& nodes() const noexcept { return nodes_; }  // [0]: the root, which is no stage
  [[nodiscard]] std::uint32_t present() const noexcept { return present_; }
  // Of the present step, for the trace, and how many more there was no room for.
  std::vector<TraceEvent> events;
  std::uint64_t dropped = 0;
  void clear();

  bool in_tile = false;

 private:
  struct Key {
    const char* name;
    Kind kind;
    bool region;
    std::uint32_t of_region, team;
    [[nodiscard]] bool is(const Node& node) const noexcept;
  };
  bool measure(Node& stage) noexcept;  // sets the weight of this tile, and when the next is measured
  bool enter(const Key& key, Nanoseconds time) noexcept;
  void leave(Nanoseconds time) noexcept;
  void keep(const TraceEvent& event) noexcept;

  Recording& recording_;
  std::uint32_t number_;
  std::uint32_t present_ = 0;
  std::uint32_t depth_ = 0;   // of the present stage; the root has 0
  std::uint32_t weight_ = 1;  // of the present tile
  std::uint64_t random_ = 1;
  Nanoseconds overhead_ = 0;  // of the parts of tiles so far
  std::vector<Node> nodes_;
};

}  // namespace springnet::profile
