// Work that falls into parts that do not know each other, in threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace springnet::learning {

// Calls work(k) once for each k below `count`, in up to so many threads, of which this is one. Once all have ended,
// throws what the call with the least k has thrown, so that it does not depend on the threads.
template <class Work>
void in_threads(std::size_t count, unsigned threads, const Work& work) {
  std::vector<std::exception_ptr> failures(count);
  std::atomic<std::size_t> next{0};
  const auto take = [&]() noexcept {
    for (std::size_t k = next++; k < count; k = next++) {
      try {
        work(k);
      } catch (...) {
        failures[k] = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> team;
    const std::size_t helpers = std::min<std::size_t>(threads, count);
    team.reserve(helpers);
    for (std::size_t k = 1; k < helpers; ++k) {
      try {
        team.emplace_back(take);
      } catch (const std::system_error&) {
        break;  // no more threads: those that there are do it all
      }
    }
    take();
  }
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace springnet::learning
