// Marks in the code whose time a profile shows. Without a profiler each costs a look at a number.
//
//   void Engine::settle() {
//     const profile::Stage stage("settle");
//
// is all that a new stage needs; it is a part of whatever stage is open. Stages take the time of every call, so they
// are for calls that take microseconds: a host function, a search, a file. What is done tile by tile or node by node is
// shorter than that. There a Tile decides whether this tile is measured, about one in 256, and a Part takes the time of
// a piece of it.
#pragma once

#include <atomic>
#include <cstdint>

#include "profile/lane.hpp"

namespace springnet::profile {

// What the calling thread records into; null: nothing.
struct Current {
  Lane* stages;  // within a scope of a profiler
  Lane* parts;   // within a measured tile of it
};
// Within this library only: the shorter access needs no call.
extern thread_local constinit Current current [[gnu::tls_model("initial-exec"), gnu::visibility("hidden")]];
// How many scopes are open, of all threads: without any, a mark costs a look at this.
extern std::atomic<std::uint32_t> open_scopes [[gnu::visibility("hidden")]];
[[nodiscard]] inline bool any_open() noexcept { return open_scopes.load(std::memory_order_relaxed) != 0; }

// name: copied. Within a tile it does nothing: a plugin may call host functions there.
class Stage {
 public:
  explicit Stage(const char* name, Kind kind = Kind::stage) noexcept {
    if (any_open()) [[unlikely]]
      begin(kind, name);
  }
  ~Stage() {
    if (lane_ != nullptr) [[unlikely]]
      end();
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

 private:
  void begin(Kind kind, const char* name) noexcept;
  void end() noexcept;

  Lane* lane_ = nullptr;
};

// A tile, a batch of elements or a node: the least that is measured. One in another one is a part of that.
class Tile {
 public:
  Tile() noexcept {
    if (any_open()) [[unlikely]]
      begin();
  }
  ~Tile() {
    if (lane_ != nullptr) [[unlikely]]
      end();
  }
  Tile(const Tile&) = delete;
  Tile& operator=(const Tile&) = delete;

 private:
  void begin() noexcept {
    Lane* const lane = current.stages;
    if (lane == nullptr || lane->in_tile) return;
    lane_ = lane;
    lane->in_tile = true;
    if (lane->measures_next()) current.parts = lane;
  }
  void end() noexcept {
    lane_->in_tile = false;
    current.parts = nullptr;
  }

  Lane* lane_ = nullptr;
};

class Part {
 public:
  explicit Part(const char* name, Kind kind = Kind::stage) noexcept {
    if (any_open()) [[unlikely]]
      begin(kind, name);
  }
  ~Part() {
    if (lane_ != nullptr) [[unlikely]]
      lane_->end_part();
  }
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

 private:
  void begin(Kind kind, const char* name) noexcept {
    lane_ = current.parts;
    if (lane_ != nullptr && !lane_->begin_part(kind, name)) lane_ = nullptr;
  }

  Lane* lane_ = nullptr;
};

// Around a parallel region, on the thread that starts it. threads: at most.
class Region {
 public:
  explicit Region(unsigned threads) noexcept {
    if (any_open()) [[unlikely]]
      begin(threads);
  }
  ~Region() {
    if (lane_ != nullptr) [[unlikely]]
      lane_->end_region();
  }
  Region(const Region&) = delete;
  Region& operator=(const Region&) = delete;

 private:
  friend class Share;
  void begin(unsigned threads) noexcept;

  Lane* lane_ = nullptr;
  std::uint32_t stage_ = none;  // that it is in, and itself: nodes of the first lane
  std::uint32_t region_ = none;
};

// In the region, on each of its threads, up to where it waits for the others (so `nowait`).
class Share {
 public:
  // Numbers of OpenMP: of this thread, and of all in the region.
  Share(const Region& region, int thread, int threads) noexcept {
    if (region.lane_ != nullptr) [[unlikely]]
      begin(region, static_cast<std::uint32_t>(thread), static_cast<std::uint32_t>(threads));
  }
  ~Share() {
    if (lane_ != nullptr) [[unlikely]]
      end();
  }
  Share(const Share&) = delete;
  Share& operator=(const Share&) = delete;

 private:
  void begin(const Region& region, std::uint32_t thread, std::uint32_t threads) noexcept;
  void end() noexcept;

  Lane* lane_ = nullptr;
  std::uint32_t stage_ = none;
};

}  // namespace springnet::profile
