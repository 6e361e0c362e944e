// Springs seen from nodes of a list, in batches that one call of each law evaluates.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "layers/law_pair.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// Most nodes of a list.
inline constexpr std::size_t together_limit = 64;
// Most springs of a batch: what is touched of their arrays fits the first-level cache.
inline constexpr std::size_t together_springs = 256;

// A batch: springs of one group, those of a node side by side.
struct NodeSprings {
  struct Piece {
    std::uint32_t node;        // index in the list
    std::uint32_t begin, end;  // its springs
  };
  std::uint32_t group = 0;
  std::span<const std::uint32_t> other;  // [spring] the other end
  std::span<const Piece> pieces;
  RowSelection rows;
  const std::uint32_t* places = nullptr;  // [spring] of internal states; null: the laws have none
};

// Memory for a batch.
class NodeSpringsBuffer {
 public:
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] NodeSprings view(std::uint32_t group) const noexcept {
    return {group,
            {other_, count_},
            {pieces_, piece_count_},
            is_mixed_ ? RowSelection{row_} : RowSelection{nullptr, row_[0]},
            places_};
  }
  void clear() noexcept {
    count_ = piece_count_ = 0;
    is_mixed_ = false;
    places_ = nullptr;
  }
  // The first `size` springs from `from` on, of a node of the list.
  void append(std::uint32_t index, const Incident* from, std::size_t size, const InternalLayout& internal) noexcept {
    if (internal.has(from->group)) {
      places_ = place_;
      for (std::size_t i = 0; i < size; ++i) place_[count_ + i] = internal.of_spring(from[i].spring);
    }
    std::uint32_t differs = 0;
    if (count_ == 0) row_[0] = from->row;
    const std::uint32_t row_0 = row_[0];
    for (std::size_t i = 0; i < size; ++i) {
      other_[count_ + i] = from[i].other;
      row_[count_ + i] = from[i].row;
      differs |= from[i].row ^ row_0;
    }
    is_mixed_ = is_mixed_ || differs != 0;
    const auto begin = static_cast<std::uint32_t>(count_);
    pieces_[piece_count_++] = {index, begin, begin + static_cast<std::uint32_t>(size)};
    count_ += size;
  }

 private:
  // Not initialised: written before they are read.
  std::uint32_t other_[together_springs], row_[together_springs], place_[together_springs];
  NodeSprings::Piece pieces_[together_limit];
  std::size_t count_ = 0, piece_count_ = 0;
  bool is_mixed_ = false;
  const std::uint32_t* places_ = nullptr;
};

// Calls take(batch) for all springs of up to together_limit nodes, group by group, until a status is not SPRINGNET_OK.
// Which springs of a node share a batch influences no result.
template <class Take>
springnet_status for_each_batch(const Layout& layout, std::span<const std::uint32_t> list, const Take& take) {
  NodeSpringsBuffer springs;
  const Incident* next[together_limit];
  for (std::size_t i = 0; i < list.size(); ++i) next[i] = layout.incident_begin(list[i]);
  const std::vector<Group>& groups = layout.laws().groups;
  for (std::uint32_t g = 0; g < groups.size(); ++g) {
    springs.clear();
    for (std::size_t i = 0; i < list.size();) {
      const Incident* end = layout.incident_end(list[i]);
      if (groups.size() > 1) end = std::find_if(next[i], end, [g](const Incident& s) { return s.group != g; });
      const auto wanted = static_cast<std::size_t>(end - next[i]);
      if (springs.size() > 0 && springs.size() + wanted > together_springs) {
        if (const springnet_status status = take(springs.view(g)); status != SPRINGNET_OK) return status;
        springs.clear();
      }
      // A node's springs are divided only if they do not fit at all.
      const std::size_t size = std::min(wanted, together_springs);
      if (size > 0) springs.append(static_cast<std::uint32_t>(i), next[i], size, layout.internal());
      next[i] += size;
      if (size == wanted) ++i;
    }
    if (springs.size() == 0) continue;
    if (const springnet_status status = take(springs.view(g)); status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
