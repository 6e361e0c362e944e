#include <springnet/current_call.hpp>

#include "plugin_host/calling.hpp"

namespace springnet {

namespace {

// initial-exec: reading it in a signal handler must not allocate, as the default model may.
constinit thread_local const Calling* innermost_call __attribute__((tls_model("initial-exec"))) = nullptr;

}  // namespace

const Calling*& Calling::innermost() noexcept { return innermost_call; }

CurrentCall current_call() noexcept {
  const Calling* const call = innermost_call;
  std::atomic_signal_fence(std::memory_order_acquire);
  return call == nullptr ? CurrentCall{} : call->call_;
}

}  // namespace springnet
