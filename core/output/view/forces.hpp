// The scene's forces that a page draws as arrows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <springnet/network.hpp>

#include "output/view/selection.hpp"

namespace springnet::view {

// One on one node while from <= time < until.
struct Force {
  std::uint32_t node;  // place in Selection::nodes
  Vector3 force;       // N
  double from, until;  // s, may be infinite
};

struct Forces {
  std::size_t all = 0;             // that the scene has, each node of each load counted
  std::vector<Force> drawn;        // these, or some of them
  std::vector<std::string> notes;  // where these are not all
};

// More arrows than this are a thicket: then some, spread over all.
inline constexpr std::size_t most_arrows = 200;

[[nodiscard]] Forces forces_of(const Network& network, const Selection& selection);

}  // namespace springnet::view
