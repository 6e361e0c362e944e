// Notes that the calling thread is in a component's function; see springnet/current_call.hpp.
#pragma once

#include <atomic>

#include <springnet/current_call.hpp>

namespace springnet {

// From construction to destruction. Costs a few stores: signal handlers alone read it.
class Calling {
 public:
  explicit Calling(const Component& component, const CalledMembers& members = {}) noexcept
      : call_{&component, members}, outer_(innermost()) {
    std::atomic_signal_fence(std::memory_order_release);
    innermost() = this;
    std::atomic_signal_fence(std::memory_order_release);
  }
  ~Calling() {
    std::atomic_signal_fence(std::memory_order_release);
    innermost() = outer_;
  }
  Calling(const Calling&) = delete;
  Calling& operator=(const Calling&) = delete;

 private:
  friend CurrentCall current_call() noexcept;

  CurrentCall call_;
  const Calling* outer_;
  // Of this thread.
  [[nodiscard]] SPRINGNET_API static const Calling*& innermost() noexcept;
};

}  // namespace springnet
