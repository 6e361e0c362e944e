// Sparsity pattern of a matrix of 3 x 3 blocks over nodes, row by row; the blocks themselves are arrays of count().
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace springnet::layers {

class BlockRows {
 public:
  // columns(node, list) appends the column nodes of a row, in any order, repeats allowed. A row that is not empty gets
  // a diagonal block too.
  template <class Columns>
  void make(std::uint32_t node_count, const Columns& columns);

  [[nodiscard]] std::size_t count() const noexcept { return others_.size(); }
  // Blocks of a row: the diagonal one first, then the others by rising column.
  [[nodiscard]] std::size_t begin(std::uint32_t node) const noexcept { return start_[node]; }
  [[nodiscard]] std::size_t end(std::uint32_t node) const noexcept { return start_[node + 1]; }
  [[nodiscard]] std::uint32_t other(std::size_t block) const noexcept { return others_[block]; }
  // Index of a block that exists.
  [[nodiscard]] std::uint32_t find(std::uint32_t row, std::uint32_t column) const noexcept;

 private:
  void end_row(std::uint32_t node, std::vector<std::uint32_t>& columns);

  std::vector<std::uint32_t> start_;
  std::vector<std::uint32_t> others_;
};

template <class Columns>
void BlockRows::make(std::uint32_t node_count, const Columns& columns) {
  start_.assign(1, 0);
  others_.clear();
  std::vector<std::uint32_t> row;
  for (std::uint32_t node = 0; node < node_count; ++node) {
    row.clear();
    columns(node, row);
    end_row(node, row);
  }
}

}  // namespace springnet::layers
