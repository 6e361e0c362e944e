// Error message for a failure of CVODE: what happened, when, and what to do.
#pragma once

#include <string>

#include "settings.hpp"

namespace springnet::cvode {

// A flag of our own beside CVODE's: many steps do not advance the time.
inline constexpr int creeping = -1000;

struct FailureFacts {
  int flag = 0;               // return value of CVode, or creeping
  double time = 0.0;          // s
  double last_step = 0.0;     // s
  std::string reason;         // from the host function that failed last, or empty
  std::string cvode_message;  // CVODE's own message
};

[[nodiscard]] std::string failure_text(const FailureFacts& facts, const Settings& settings);

}  // namespace springnet::cvode
