// Runs code that may crash, hang or end its process in a child process.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "check/report.hpp"

namespace springnet::check {

struct Limits {
  double seconds = 20.0;               // of wall time, and of processor time for each of `threads`
  unsigned threads = 1;                // that the body uses at a time
  std::size_t memory = 2'000'000'000;  // bytes beyond what the process has; not with sanitizers, which reserve more
};

// Runs `body` in a child process and returns its outcome; how the child ended, if it did not get there: crashed or
// timed_out. `subject`: who is blamed, as "the law". An exception is a failure. What the child prints is dropped. Not
// while the calling process has other threads.
[[nodiscard]] Outcome run_in_child(const std::function<Outcome()>& body, const Limits& limits, const char* subject);

// How a supervised process ended.
struct End {
  Outcome outcome;              // passed: in order
  bool was_leaving = false;     // the body had returned: what went wrong are destructors
  std::string component, kind;  // that it was in; empty: none
  std::string told;             // by tell(), up to its end
};
// Runs `body`, which loads foreign code and may run checks in children of its own, in a child process. That ends by
// exit(), so that destructors of libraries run. It is killed if it takes longer than `seconds` from one now_doing() to
// the next. Otherwise as run_in_child(), but `body` has to catch its exceptions.
[[nodiscard]] End supervise(const std::function<void()>& body, double seconds, const char* subject);
// Within a supervised process: sends bytes to the process that waits for it.
void tell(std::string_view bytes) noexcept;

// Within a child: what it does now, "evaluating 8 elements", for the report of a crash.
void now_doing(const char* what) noexcept;

}  // namespace springnet::check
