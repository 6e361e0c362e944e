// Groups of constraints that are connected by what they move: nodes, or clusters of them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

namespace springnet {

class RowGroups {
 public:
  using Part = std::pair<bool, std::uint32_t>;  // a node; or, true, a cluster

  explicit RowGroups(std::size_t rows) : parent_(rows), moves_(rows, 0) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  void connect(std::uint32_t row, Part part) {
    moves_[row] = 1;
    const std::uint32_t other = root(first_.try_emplace(part, row).first->second), own = root(row);
    parent_[std::max(other, own)] = std::min(other, own);
  }
  // In the order of their first rows, those in ascending order; without rows that move nothing.
  [[nodiscard]] std::vector<std::vector<std::uint32_t>> groups() {
    std::vector<std::vector<std::uint32_t>> result;
    std::vector<std::uint32_t> place(parent_.size());
    for (std::uint32_t r = 0; r < parent_.size(); ++r) {
      if (moves_[r] == 0) continue;
      const std::uint32_t own = root(r);
      if (own == r) {
        place[r] = static_cast<std::uint32_t>(result.size());
        result.emplace_back();
      }
      result[place[own]].push_back(r);
    }
    return result;
  }

 private:
  std::uint32_t root(std::uint32_t row) {
    while (parent_[row] != row) row = parent_[row] = parent_[parent_[row]];
    return row;
  }

  std::vector<std::uint32_t> parent_;
  std::vector<std::uint8_t> moves_;
  std::map<Part, std::uint32_t> first_;  // row of a part
};

}  // namespace springnet
