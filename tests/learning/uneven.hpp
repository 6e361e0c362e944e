// Nets whose nodes are not alike.
#pragma once

#include <cstdint>

#include "generator.hpp"
#include "nets.hpp"

namespace springnet::testing {

// Moves each node within a box (half its side, m), and gives it a mass at random and the velocity (m/s) of its place,
// with a part at random, too.
template <class Velocity>
void make_uneven(Network& net, std::uint64_t seed, double place, double speed, const Velocity& velocity) {
  Dice dice(seed);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.position += dice.in_box(place);
    own.velocity = velocity(own.position) + dice.in_box(speed);
    own.mass = dice.between(0.5, 2.0);
    net.set_node(k, own);
  }
}

}  // namespace springnet::testing
