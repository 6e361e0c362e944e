// Notes that the calling thread is in a component's function; see springnet/current_call.hpp.
#pragma once

#include <atomic>

#include <springnet/current_call.hpp>

namespace springnet {

// From construction to destruction. Costs a few stores: signal handlers alone read it.
class Calling {
 public:
  explicit Calling(const Component& component, const CalledMembers& members = {}) noexcept
      : call_{&component, members}, outer_(innermost_) {
    std::atomic_signal_fence(std::memory_order_release);
    innermost_ = this;
    std::atomic_signal_fence(std::memory_order_release);
  }
  ~Calling() {
    std::atomic_signal_fence(std::memory_order_release);
    innermost_ = outer_;
  }
  Calling(const Calling&) = delete;
  Calling& operator=(const Calling&) = delete;

 private:
  friend CurrentCall current_call() noexcept;

  CurrentCall call_;
  const Calling* outer_;
  // initial-exec: reading it in a signal handler must not allocate, as the default model may.
  SPRINGNET_API static constinit thread_local const Calling* innermost_ __attribute__((tls_model("initial-exec")));
};

}  // namespace springnet
