// Counts touches of nodes in quick succession.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "layers/numbers_before.hpp"
#include "text/archive.hpp"

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
  void take_over(const RecentTouches& before, const layers::NumbersBefore& numbers) {
    numbers.for_each_node([&](std::uint32_t k, std::uint32_t old) {
      if (const auto row = before.rows_.find(old); row != before.rows_.end()) rows_[k] = row->second;
    });
  }
  void archive(Archive& archive) {
    std::vector<std::pair<std::uint32_t, Row>> rows(rows_.begin(), rows_.end());
    rows.resize(archive.count(rows.size(), sizeof(std::uint32_t) + sizeof(int) + sizeof(double), "touches"));
    for (auto& [node, row] : rows) {
      archive.number(node);
      archive.number(row.touches);
      archive.number(row.last);
    }
    if (archive.reads()) rows_ = {rows.begin(), rows.end()};
  }

 private:
  struct Row {
    int touches = 0;
    double last = -std::numeric_limits<double>::infinity();  // s
  };
  std::map<std::uint32_t, Row> rows_;
};

}  // namespace springnet
