// Rows [t, …] of numbers over time, and their interpolation.
#pragma once

#include <vector>

#include <fmt/format.h>

#include "scene/reader.hpp"

namespace springnet::scene {

// Reads the rows of a table. `form`: a row for messages, as "[t, factor]". Calls take(time, numbers) for each row:
// time, s, and its `columns` numbers, the time first.
template <class Take>
void read_time_table(const Value& table, std::string_view form, std::size_t columns, const Take& take) {
  const std::vector<Value> rows = table.elements();
  if (rows.size() < 2) table.fail(fmt::format("needs two rows {} or more, has {}", form, rows.size()));
  double last = 0.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::vector<Value> numbers = rows[k].elements(columns);
    const double time = numbers[0].number();
    if (k > 0 && !(last < time)) {
      numbers[0].fail(fmt::format("times must increase, but {} s follows {} s; sort the rows, and give each time once",
                                  time, last));
    }
    last = time;
    take(time, numbers);
  }
}

[[nodiscard]] inline Motion::Interpolation read_interpolation(const Table& table) {
  const auto given = table.find("interpolation");
  return given && given->choice({"smooth", "linear"}) == 1 ? Motion::Interpolation::linear
                                                           : Motion::Interpolation::smooth;
}

// Refuses keys that cannot be combined with another.
inline void refuse_beside(const Table& table, std::initializer_list<std::string_view> keys, std::string_view other) {
  for (const std::string_view key : keys) {
    if (const auto value = table.find(key)) value->fail(fmt::format("cannot be combined with '{}'; remove it", other));
  }
}

}  // namespace springnet::scene
