// The scene's loads as a page draws them: the resultant of each load, and forces on nodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

#include "view/selection.hpp"

namespace springnet::view {

// A load whose force is not zero; its arrows follow those of the load before it.
struct DrawnLoad {
  // A spring along an edge of one of the load's faces: the face is removed with it.
  struct Side {
    std::size_t face;
    SpringIndex spring;
  };
  std::size_t load;   // of Network::loads()
  std::size_t nodes;  // that it acts on
  std::size_t arrows;
  std::vector<Side> sides{};
};

// A force of a drawn load on a node that is shown.
struct Arrow {
  std::size_t drawn;   // place in Forces::loads
  std::uint32_t node;  // place in Selection::nodes
  NodeIndex user;      // the user's number of the node
};

struct Forces {
  std::size_t all = 0;             // number of forces in the scene, one per load and node
  std::vector<DrawnLoad> loads;    // those with a shown node, or a sample of them
  std::vector<Arrow> arrows;       // their forces on shown nodes, or a sample for each load
  std::vector<std::string> notes;  // what is left out
};

// More arrows than this are unreadable: then only a sample of each load is drawn.
inline constexpr std::size_t max_arrows = 200;

[[nodiscard]] Forces forces_of(const Network& network, const Selection& selection);

// The forces now, N: x, y, z of the resultant of each drawn load and of each arrow. A resultant that is mere rounding
// of cancelling forces is zero.
void take_forces(const Forces& forces, const Network& network, const Simulation& simulation,
                 std::span<float> resultants, std::span<float> arrows);

}  // namespace springnet::view
