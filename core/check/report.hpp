// What a check of a component found.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace springnet::check {

// passed and warned are good enough to use the component. crashed: a signal, or the component ended the process.
enum class Result { passed, warned, failed, crashed, timed_out, skipped };
// "pass", "warn", "fail", "crash", "timeout", "skipped".
[[nodiscard]] const char* name_of(Result result) noexcept;
[[nodiscard]] constexpr bool is_bad(Result result) noexcept {
  return result == Result::failed || result == Result::crashed || result == Result::timed_out;
}

struct Outcome {
  Result result = Result::passed;
  std::string why;  // one line: numbers, and what to do
};

struct Finding {
  std::string component;  // its id; the file where there is none yet
  std::string kind;       // "spring function" …; "plugin" for a file
  std::string check;      // "load", "arrays" …
  Outcome outcome;
};

struct Report {
  std::uint64_t seed = 0;
  bool loaded = true;  // false: a plugin was refused, or ended its process while it was loaded
  std::vector<Finding> findings;
  [[nodiscard]] bool passed() const noexcept;  // nothing bad
};

}  // namespace springnet::check
