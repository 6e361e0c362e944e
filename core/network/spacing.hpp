// Whether coordinates still tell how far nodes are apart.
#pragma once

#include <cstddef>

#include <springnet/network.hpp>

namespace springnet {

// How many of each a check leaves out, because they have been checked.
struct Checked {
  std::size_t springs = 0, elements = 0, rigids = 0;
};

// Throws Error(input) for the first spring, element or rigid connection whose length is lost to the rounding of its
// nodes' coordinates: far from the origin the distance of neighbouring numbers comes near the length.
void check_spacing(const Network& network, const Checked& checked = {});

}  // namespace springnet
