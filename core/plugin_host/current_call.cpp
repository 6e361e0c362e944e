#include <springnet/current_call.hpp>

#include "plugin_host/calling.hpp"

namespace springnet {

constinit thread_local const Calling* Calling::innermost_ = nullptr;

CurrentCall current_call() noexcept {
  const Calling* const call = Calling::innermost_;
  std::atomic_signal_fence(std::memory_order_acquire);
  return call == nullptr ? CurrentCall{} : call->call_;
}

}  // namespace springnet
