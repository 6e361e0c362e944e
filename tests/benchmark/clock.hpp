// Clocks of the tables.
#pragma once

#include <chrono>
#include <ctime>

namespace springnet::benchmark {

enum class Clock { wall, thread };

// s
inline double now(Clock clock) {
  if (clock == Clock::wall)
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace springnet::benchmark
