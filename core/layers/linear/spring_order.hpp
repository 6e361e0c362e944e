// The springs of each unit by their first nodes, for loops that go through them node by node and add to both ends at
// once. Springs between nodes of a unit are there once; those that lead out of it are in the unit of their other end,
// too, so that no thread writes to nodes of another unit.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "layers/layout.hpp"

namespace springnet::layers {

struct SpringsOfUnit {
  // Those of node k of the unit are start[k - first_node] to start[k - first_node + 1].
  struct Part {
    std::vector<std::uint32_t> start, second;
  };
  // A spring from the unit before: its place in `leaving` of this unit and of that one.
  struct Incoming {
    std::uint32_t place, from;
  };
  Part within, leaving;
  std::vector<std::uint32_t> place;  // [slot of the unit] among those within, and after these those that leave
  std::vector<Incoming> incoming;
};

class SpringOrder {
 public:
  // It must outlive this.
  explicit SpringOrder(const Layout& layout) : layout_(layout) {}

  // To be called before the functions below. Whether anything has changed since the last call.
  bool follow();
  [[nodiscard]] const std::vector<SpringsOfUnit>& units() const noexcept { return units_; }
  // Ends of a spring of a segment, that in the unit first.
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> ends_in(std::size_t unit, const Segment& segment,
                                                                std::uint32_t spring) const;

 private:
  const Layout& layout_;
  std::optional<std::uint64_t> laid_out_{};  // revision of the layout
  std::vector<SpringsOfUnit> units_;
};

}  // namespace springnet::layers
