// Number of repetitions of a test: few in the suite, many from tests/endurance.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace springnet::testing {

// The value of the environment variable, or that of the suite if it is not set.
inline std::uint64_t repetitions(const char* variable, std::uint64_t in_suite) {
  const char* const given = std::getenv(variable);
  return given == nullptr ? in_suite : std::strtoull(given, nullptr, 10);
}

}  // namespace springnet::testing
