// Runs code that may crash, hang or end its process in a child process.
#pragma once

#include <functional>

#include "check/report.hpp"

namespace springnet::check {

struct Limits {
  double seconds = 20.0;               // of wall time and of processor time, each
  std::size_t memory = 2'000'000'000;  // bytes beyond what the process has; not with sanitizers, which reserve more
};

// Runs `body` in a child process and returns its outcome; how the child ended, if it did not get there: crashed or
// timed_out. `subject`: who is blamed, as "the law". An exception is a failure. What the child prints is dropped. Not
// while the calling process has other threads.
[[nodiscard]] Outcome run_in_child(const std::function<Outcome()>& body, const Limits& limits, const char* subject);

// Within a child: what it does now, "evaluating 8 elements", for the report of a crash.
void now_doing(const char* what) noexcept;

}  // namespace springnet::check
