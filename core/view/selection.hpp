// Which nodes, springs and faces of a network a page draws.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <springnet/network.hpp>

namespace springnet::view {

inline constexpr std::uint32_t not_shown = std::numeric_limits<std::uint32_t>::max();

struct Selection {
  std::vector<NodeIndex> nodes;                         // shown, ascending
  std::vector<SpringIndex> springs;                     // shown, ascending
  std::vector<std::uint32_t> node_place, spring_place;  // by the user's number: place in the two above, or not_shown
  bool faces = true;
  std::vector<std::string> notes;  // what is left out
};

// Everything, if that many frames take at most `bytes` (before base64). Otherwise as many springs as fit, evenly
// spread: those on faces, if there are faces. more: further bytes of a spring in a frame, on average.
[[nodiscard]] Selection select(const Network& network, double frames, double bytes, double more = 0.0);

// Bytes needed once, and per frame, with 16 bit numbers in frames.
struct Cost {
  double once = 0.0;
  double frame = 0.0;
};
[[nodiscard]] Cost cost_of(double nodes, double springs);

}  // namespace springnet::view
