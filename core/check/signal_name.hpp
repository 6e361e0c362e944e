// Names of the signals by which processes crash.
#pragma once

#include <csignal>
#include <string_view>

namespace springnet::check {

// "SIGSEGV"; empty for a signal that is no crash. Async-signal-safe.
[[nodiscard]] constexpr std::string_view signal_name(int number) noexcept {
  switch (number) {
    case SIGSEGV:
      return "SIGSEGV";
    case SIGBUS:
      return "SIGBUS";
    case SIGFPE:
      return "SIGFPE";
    case SIGILL:
      return "SIGILL";
    case SIGABRT:
      return "SIGABRT";
    case SIGKILL:
      return "SIGKILL";
    default:
      return {};
  }
}

}  // namespace springnet::check
