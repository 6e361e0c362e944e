// The friction of all surfaces of a network, by their numbers.
#pragma once

#include <string>

#include <springnet/network.hpp>

namespace springnet::learning {

// use(name, friction): of planes, then of instruments.
template <class Use>
void for_each_surface(const Network& network, const Use& use) {
  for (const Plane& each : network.planes()) use(each.name, each.friction);
  for (const Instrument& each : network.instruments()) use(each.name, each.friction);
}

}  // namespace springnet::learning
