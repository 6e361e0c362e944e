// Work in parts that do not know each other, for threads. Parts do not depend on the number of threads, and their
// results are put one after the other, so neither do these. (Which of several errors is thrown may.)
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <vector>

namespace springnet::proximity {

// Calls work(begin, end, result) for ranges of `part` numbers below `count`, and appends the results to `found` in
// order. Throws what the first part that failed has thrown.
template <class Item, class Work>
void append_in_parts(std::size_t count, std::size_t part, unsigned threads, std::vector<Item>& found,
                     const Work& work) {
  const std::size_t parts = (count + part - 1) / part;
  if (threads <= 1 || parts <= 1) {
    for (std::size_t k = 0; k < parts; ++k) work(k * part, std::min(count, (k + 1) * part), found);
    return;
  }
  std::vector<std::vector<Item>> results(parts);
  std::vector<std::exception_ptr> failures(parts);
#pragma omp parallel for schedule(dynamic) num_threads(static_cast <int>(threads))
  for (std::size_t k = 0; k < parts; ++k) {
    try {
      work(k * part, std::min(count, (k + 1) * part), results[k]);
    } catch (...) {
      failures[k] = std::current_exception();
    }
  }
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
  for (const auto& result : results) found.insert(found.end(), result.begin(), result.end());
}

}  // namespace springnet::proximity
