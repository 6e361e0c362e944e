// Which faces of a network are gone with what was removed.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/network.hpp>

#include "layers/layout.hpp"

namespace springnet {

// A face is torn with a spring along one of its sides, with the loads on it, or with the elements that have all of its
// corners (areas, volumes and the like), once none of these is left.
class TornFaces {
 public:
  // [face of the network] 1: torn. Found anew after removals.
  [[nodiscard]] const std::vector<std::uint8_t>& of(const Network& network, const layers::Layout& layout);

 private:
  std::vector<std::uint8_t> torn_;
  std::uint64_t revision_ = 0;  // of the layout
};

}  // namespace springnet
