// Counts touches of nodes in quick succession.
#pragma once

#include <cstdint>
#include <limits>
#include <map>

namespace springnet {

class RecentTouches {
 public:
  // Counts a touch at `time`, s. Returns how many touches in a row followed each other by at most `gap`, s.
  int count(std::uint32_t node, double time, double gap) {
    Row& row = rows_[node];
    row.touches = time - row.last <= gap ? row.touches + 1 : 1;
    row.last = time;
    return row.touches;
  }

 private:
  struct Row {
    int touches = 0;
    double last = -std::numeric_limits<double>::infinity();  // s
  };
  std::map<std::uint32_t, Row> rows_;
};

}  // namespace springnet
