#include "layers/linear/block_rows.hpp"

#include <algorithm>
#include <iterator>

namespace springnet::layers {

void BlockRows::end_row(std::uint32_t node, std::vector<std::uint32_t>& columns) {
  if (!columns.empty()) {
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    others_.push_back(node);
    std::copy_if(columns.begin(), columns.end(), std::back_inserter(others_),
                 [node](std::uint32_t other) { return other != node; });
  }
  start_.push_back(static_cast<std::uint32_t>(others_.size()));
}

std::uint32_t BlockRows::find(std::uint32_t row, std::uint32_t column) const noexcept {
  if (row == column) return start_[row];
  const auto first = others_.begin() + start_[row] + 1, last = others_.begin() + start_[row + 1];
  return static_cast<std::uint32_t>(std::lower_bound(first, last, column) - others_.begin());
}

}  // namespace springnet::layers
