// A point of wall time until which something is to be done, or until somebody asks to stop.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include "layers/linear/team.hpp"

namespace springnet {

class Deadline {
 public:
  // seconds from now on; not finite: none.
  void set(double seconds) {
    is_set_ = seconds < longest;
    if (is_set_)
      end_ = Clock::now() +
             std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds > 0.0 ? seconds : 0.0));
  }
  void clear() noexcept { is_set_ = false; }
  using Flag = std::atomic<bool>;
  // From any thread, or a signal handler: as if the time were over.
  static void ask(Flag& flag) noexcept { flag.store(true, std::memory_order_relaxed); }
  // For ask(), by whoever outlives this object.
  [[nodiscard]] const std::shared_ptr<Flag>& flag() const noexcept { return asked_; }
  void share(std::shared_ptr<Flag> flag) noexcept { asked_ = std::move(flag); }
  void forget_asking() noexcept { asked_->store(false, std::memory_order_relaxed); }
  [[nodiscard]] bool is_asked() const noexcept { return asked_->load(std::memory_order_relaxed); }
  [[nodiscard]] bool is_set() const noexcept { return is_set_ || is_asked(); }
  // s; below 0 after it, infinity if there is none.
  [[nodiscard]] double left() const {
    if (is_asked()) return -1.0;
    if (!is_set_) return std::numeric_limits<double>::infinity();
    return std::chrono::duration<double>(end_ - Clock::now()).count();
  }
  [[nodiscard]] bool has_passed() const { return is_set() && left() <= 0.0; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double longest = 1e8;  // s; the clock's range ends somewhere beyond
  bool is_set_ = false;
  std::shared_ptr<Flag> asked_ = std::make_shared<Flag>(false);
  static_assert(Flag::is_always_lock_free);
  Clock::time_point end_{};
};

namespace layers {

// Whether a deadline has passed, the same answer for all threads of a team; asked every few iterations.
class Interruption {
 public:
  // null: never.
  void set_deadline(const Deadline* deadline) noexcept { deadline_ = deadline; }
  [[nodiscard]] bool operator()(const Team& team, std::uint32_t iterations) {
    if (deadline_ == nullptr || !deadline_->is_set() || iterations % iterations_between != 0) return false;
    team.alone([&] { passed_ = deadline_->has_passed(); });
    return passed_;
  }

 private:
  static constexpr std::uint32_t iterations_between = 8;
  const Deadline* deadline_ = nullptr;
  bool passed_ = false;
};

}  // namespace layers
}  // namespace springnet
