#include <springnet/current_call.hpp>

#include <atomic>

#include <springnet/calling_threads.hpp>

#include "plugin_host/calling.hpp"

namespace springnet {

namespace {

// initial-exec: reading it in a signal handler must not allocate, as the default model may.
constinit thread_local const Calling* innermost_call __attribute__((tls_model("initial-exec"))) = nullptr;
constinit thread_local bool is_prepared __attribute__((tls_model("initial-exec"))) = false;

constinit std::atomic<void (*)() noexcept> prepare_thread{nullptr};

void prepare_this_thread() noexcept {
  is_prepared = true;
  if (const auto prepare = prepare_thread.load(std::memory_order_acquire)) prepare();
}

}  // namespace

const Calling*& Calling::innermost() noexcept {
  if (!is_prepared) [[unlikely]]
    prepare_this_thread();
  return innermost_call;
}

void prepare_calling_threads(void (*prepare)() noexcept) noexcept {
  is_prepared = false;
  prepare_thread.store(prepare, std::memory_order_release);
}

CurrentCall current_call() noexcept {
  const Calling* const call = innermost_call;
  std::atomic_signal_fence(std::memory_order_acquire);
  return call == nullptr ? CurrentCall{} : call->call_;
}

}  // namespace springnet
