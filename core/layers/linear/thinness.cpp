#include "layers/linear/thinness.hpp"

#include <cstdint>
#include <vector>

namespace springnet::layers {
namespace {

// Up to this many nodes a factorisation costs little.
constexpr std::uint32_t nodes_of_small_net = 256;

// Breadth-first searches over the parts of a net.
class BreadthSearch {
 public:
  BreadthSearch(const std::vector<std::uint32_t>& start, const std::vector<std::uint32_t>& column)
      : start_(start), column_(column), pass_(start.size() - 1, 0) {}

  [[nodiscard]] bool reached(std::uint32_t node) const { return pass_[node] != 0; }
  // Number of layers of a search from the node that another one from `first` reached last: about the greatest distance
  // in springs between two nodes of its part, whose size nodes() tells.
  std::size_t depth_from(std::uint32_t first) {
    run(first);
    return run(order_.back());
  }
  [[nodiscard]] std::size_t nodes() const { return order_.size(); }

 private:
  std::size_t run(std::uint32_t from) {
    ++last_;
    order_.assign(1, from);
    pass_[from] = last_;
    std::size_t depth = 0;
    for (std::size_t next = 0; next < order_.size(); ++depth) {
      for (const std::size_t layer_end = order_.size(); next < layer_end; ++next) {
        const std::uint32_t k = order_[next];
        for (std::uint32_t b = start_[k]; b < start_[k + 1]; ++b) {
          if (pass_[column_[b]] == last_) continue;
          pass_[column_[b]] = last_;
          order_.push_back(column_[b]);
        }
      }
    }
    return depth;
  }

  const std::vector<std::uint32_t>&start_, &column_;
  std::vector<std::uint64_t> pass_;  // [node] the last search that reached it
  std::uint64_t last_ = 0;
  std::vector<std::uint32_t> order_;
};

}  // namespace

bool is_thin(const Layout& layout) {
  const std::uint32_t n = layout.node_count();
  if (n <= nodes_of_small_net) return true;
  BreadthSearch search(layout.neighbour_start(), layout.neighbours());
  std::size_t in_thin_parts = 0;
  for (std::uint32_t k = 0; k < n; ++k) {
    if (search.reached(k)) continue;
    const std::size_t depth = search.depth_from(k);
    if (search.nodes() <= 2 * depth * depth) in_thin_parts += search.nodes();
  }
  return 2 * in_thin_parts >= n;
}

}  // namespace springnet::layers
