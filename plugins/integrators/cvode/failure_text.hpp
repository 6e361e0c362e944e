// Why CVODE gave up, in words: what happened, where, and what to do.
#pragma once

#include <string>

#include "settings.hpp"

namespace springnet::cvode {

// Beside the flags of CVODE: many steps in which the time did not go on.
inline constexpr int creeping = -1000;

struct FailureFacts {
  int flag = 0;               // what CVode returned, or creeping
  double time = 0.0;          // s
  double last_step = 0.0;     // s
  std::string reason;         // of the host function that failed last, or empty
  std::string cvode_message;  // CVODE's own words
};

[[nodiscard]] std::string failure_text(const FailureFacts& facts, const Settings& settings);

}  // namespace springnet::cvode
